#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "config/recording_writer.h"
#include "core/base/result.h"
#include "core/scene/recording.h"
#include "drivers/acquire/acquire.h"

namespace rigcal {

struct CaptureRequest {
  std::filesystem::path out;  ///< folder of the recording
  std::string id;             ///< of the recording
  Subject subject = Subject::kObject;
  AcquisitionPlan plan;  ///< of the whole recording
  /// Two poses of an arm are one stop within these; one that is resumed has to be where it was.
  double same_place_rad = PositionerSettings{}.position_tolerance_rad;
  double same_place_m = PositionerSettings{}.position_tolerance_m;
  bool resume = false;   ///< `out` holds a recording that was interrupted
  RecordingOrder order;  ///< of the closed recording; empty: stop by stop, camera by camera
  /// Free space where a folder is or will be; empty: as the system tells it.
  std::function<Result<std::uintmax_t>(const std::filesystem::path& folder)> free_bytes;
};

struct CaptureOutcome {
  AcquisitionOutcome acquisition;
  Recording recording;  ///< closed
};

/// Room that must be left beside the pictures: recording.json, and everything else on the disk.
inline constexpr std::uintmax_t kReserve_bytes = 64u << 20;

/// What the pictures of the plan's stops take at most, without compression.
std::uintmax_t BytesNeeded(const AcquisitionDevices& devices, const AcquisitionPlan& plan);

/// Takes a recording: acquisition into `out`, closed at the end. Resuming takes only the views that the recording does
/// not list. Errors: kDiskFull before anything moves (before the pictures of each stop where a positioner says its
/// stops itself), with what is free and what is needed; kBadInput: the cameras are not of one kind (linear), or a
/// recording that is resumed has others, another subject, or stops that are none of the plan's or at another place, or
/// an arm that resumes a stop is elsewhere; kDevice: an arm ended without coming again to a stop of which pictures are
/// missing; those of RecordingWriter and Acquire. What was taken before an error is in a recording that is not closed.
Result<CaptureOutcome> CaptureRecording(const AcquisitionDevices& devices, const CaptureRequest& request,
                                        const std::function<void(const AcquisitionProgress&)>& listener,
                                        const std::stop_token& stop);

}  // namespace rigcal
