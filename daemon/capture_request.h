#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "config/rig_file.h"
#include "core/base/clock.h"
#include "core/base/result.h"
#include "daemon/capture_run.h"
#include "drivers/driver.h"

namespace rigcal {

/// What a capture with the devices of a rig is asked for, on the command line or by a job.
struct CaptureWish {
  std::filesystem::path out;  ///< folder of the recording, whose name becomes its id
  Subject subject = Subject::kObject;
  std::vector<double> stops;  ///< in place of the rig's, for a rig with one axis: degrees or metres; empty: the rig's
  bool resume = false;        ///< `out` was interrupted: take what is missing
};

/// What is to be captured with which devices.
struct PreparedCapture {
  RigHardware hardware;
  DriverContext context;
  CaptureRequest request;
};

/// The capture of a rig; `rig_name` names its file in messages. Errors: kBadInput: a rig without cameras, or without
/// stops; kUnsupported: several stops and nothing that moves; those of ReadFile and ParseBoard for the rig's board.
Result<PreparedCapture> PrepareCapture(const CaptureWish& wish, const RigFile& rig, const std::string& rig_name);

/// Opens the devices and takes the recording. Sentences for whoever works with the rig go to capture.context.tell.
/// Errors: those of OpenRig and CaptureRecording.
Result<CaptureOutcome> CaptureWithDevices(PreparedCapture& capture, Clock& clock,
                                          const std::function<void(const AcquisitionProgress&)>& listener,
                                          const std::stop_token& stop);

/// Nothing for a word that is none of "chart", "object", "both".
std::optional<Subject> SubjectNamed(const std::string& name);

}  // namespace rigcal
