#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "daemon/jobs/job_work.h"

namespace rigcal {

/// Takes pictures of the object with all cameras at all stops, and keeps them as a recording. No verdict.
Result<JobOutcome> CaptureJob(JobWork& work);
/// Takes pictures of the chart and calibrates the cameras from them: the first calibration of a rig, or a new one.
Result<JobOutcome> SeedChartJob(JobWork& work);
/// Takes pictures of whatever stands on the table and refines the calibration in force.
Result<JobOutcome> RecalibrateJob(JobWork& work);
/// The same from a recording that is there.
Result<JobOutcome> ReplayJob(JobWork& work);

/// One key of a job's request.
struct RequestKey {
  std::string_view name;
  enum class Type { kText, kSubject, kMasks, kNumber, kWhole, kNumbers } type = Type::kText;
  bool required = false;
  double least = 0, most = 0;  ///< of numbers
};

/// One thing that the service can be asked to do. A new one is a row of the table, and its function.
struct JobKind {
  std::string_view name;
  std::string_view meaning;
  std::span<const RequestKey> keys;
  Result<JobOutcome> (*run)(JobWork& work);
};

/// All of them.
std::span<const JobKind> JobKinds();
/// Nothing for another name.
const JobKind* FindJobKind(std::string_view name);

/// Whether a request is one of the kind's: an object with its keys alone, each of its type and in its range. Errors:
/// kBadInput, naming the key and what is allowed.
Result<void> CheckJobRequest(const JobKind& kind, const nlohmann::json& request);

}  // namespace rigcal
