#pragma once

#include <optional>

#include "daemon/run_context.h"

namespace rigcal {

/// Where a running job stands, for people.
struct JobProgress {
  RunProgress run;
  std::optional<double> left_s;  ///< until the run is over; nothing as long as that is a guess
};

/// From the share of a run that is done after `elapsed_s`; nothing before enough is done to tell.
std::optional<double> TimeLeftS(const RunProgress& progress, double elapsed_s);

/// "stereo, round 2 of 4: 37 %, about 12 s left".
std::string ProgressText(const JobProgress& progress);

}  // namespace rigcal
