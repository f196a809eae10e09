#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/calibration_store.h"
#include "core/base/clock.h"
#include "core/base/result.h"
#include "core/scene/recording.h"
#include "daemon/jobs/station.h"
#include "daemon/jobs/worker.h"

namespace rigcal {

/// What a job works with. All of it outlives the job.
struct JobWork {
  const nlohmann::json& request;  ///< checked by its kind
  const Station& station;
  CalibrationStore& store;
  Clock& clock;
  JobHandle& handle;
  std::function<std::string()> now_text;                  ///< UTC, ISO 8601
  std::function<void(const std::string& sentence)> tell;  ///< the operator
};

// The steps that the kinds of jobs are made of.

/// The calibration in force, as a file in the job's folder; what is published at the end must still follow it.
struct StartingPoint {
  std::filesystem::path calibration;
  int revision = 0;
};
/// Errors: kNotFound: nothing is in force; those of the store; kIo, kDiskFull.
Result<StartingPoint> TakeCalibrationInForce(JobWork& work);

/// Takes a recording of the subject with the rig's devices into the state folder, or gives the one that the request
/// names under "recording": whole as it is, interrupted after taking what is missing. Errors: those of PrepareCapture,
/// CaptureWithDevices and JobJournal; kNotFound: there is no recording of that name; kBadInput: an interrupted one that
/// is not the service's own.
Result<std::filesystem::path> AcquireRecording(JobWork& work, Subject subject);

/// Refines the cameras of `start` from a recording, exactly as `rigcal refine --cameras calibration.json --recording R`
/// does, into the result folder that is given. Errors: those of RefineFiles.
Result<std::filesystem::path> RefineRecording(JobWork& work, const StartingPoint& start,
                                              const std::filesystem::path& recording);

/// Keeps a result as a revision and publishes it when it was accepted, provided that `expected` is still in force. The
/// revision stays, whatever follows. Errors: those of RevisionFromResult, the store and PublishRevision.
Result<JobOutcome> StoreAndPublish(JobWork& work, const std::filesystem::path& result,
                                   const std::filesystem::path& recording, const std::optional<int>& expected);

/// Where the recording of the request's key "recording" is: a name in the state folder, or an absolute path. Nothing
/// when the request names none. Errors: kNotFound: no recording is there.
Result<std::optional<std::filesystem::path>> NamedRecording(const JobWork& work);

}  // namespace rigcal
