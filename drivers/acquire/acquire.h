#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "core/scene/rig_devices.h"
#include "drivers/camera_device.h"
#include "drivers/positioner_device.h"

namespace rigcal {

/// What takes the pictures; all of it outlives the acquisition.
struct AcquisitionDevices {
  std::vector<CameraDevice*> cameras;
  PositionerDevice* positioner = nullptr;  ///< none: the studio stands as it is, and a plan has one stop
  Clock* clock = nullptr;
};

/// One stop and the cameras (indices) whose pictures are wanted there.
struct PlannedStop {
  StopTarget target;
  std::vector<int> cameras;
};

struct AcquisitionPlan {
  std::vector<PlannedStop> stops;
  /// Instead of `stops`, for a positioner that somebody else moves: it is asked for one stop after the other until
  /// there is none, and this says of which cameras pictures are wanted where it rests; none: the stop is passed over.
  /// Its Error ends the acquisition. Empty: the plan has its stops.
  std::function<Result<std::vector<int>>(const RecordedStop& reached)> cameras_at;
  double settle_s = 0;       ///< after each move, and before a picture is taken again
  CaptureSettings settings;  ///< its stops are not looked at
  /// The time, ISO 8601 in UTC, for pictures whose camera does not tell when they were taken; empty: it is not noted.
  std::function<std::string()> utc_now;
};

/// A good picture, and where the positioner stood.
struct TakenPicture {
  int camera = 0;  ///< index
  RecordedStop stop;
  CapturedPicture picture;
};

/// Stores a picture. Called from a thread of its own, one picture at a time, in the order in which they were taken. Its
/// first Error ends the acquisition.
using StorePicture = std::function<Result<void>(const TakenPicture&)>;

enum class AcquisitionPhase { kMoving, kSettling, kTaking, kStoring };

/// "moving", "settling", "taking", "waiting for the disk".
std::string_view NameOf(AcquisitionPhase phase);

/// Told at the begin of each phase of each stop.
struct AcquisitionProgress {
  AcquisitionPhase phase = AcquisitionPhase::kMoving;
  int stop = 0;
  std::optional<int> num_stops;  ///< unknown where the positioner says its stops itself
};

/// How the time was spent by the devices' clock: every second is one of these. Storing is what the devices waited for
/// the disk; what is written while the table moves costs nothing.
struct AcquisitionTimes {
  double moving_s = 0, settling_s = 0, taking_s = 0, storing_s = 0;
};

struct AcquisitionOutcome {
  AcquisitionTimes times;
  int num_pictures = 0;   ///< taken and stored
  int num_retaken = 0;    ///< taken again: it was not good, or did not come
  int num_recovered = 0;  ///< cameras brought back
};

/// The acquisition: homes, and for each stop moves (or waits for whoever moves), settles, fires all cameras together,
/// collects their pictures, checks each one and takes it again where it is bad or missing, and hands the good ones to
/// `store`, which works while the table moves on. A camera that fails is brought back, once those that did not have
/// given their pictures. However it ends, the positioner is halted, and what was taken is stored (on cancellation and
/// after an exception: but for what was still waiting). Errors: kDevice, kTimeout of the positioner; kDevice naming
/// camera and stop: gone for longer than settings.recover_s, or its picture is not good after settings.retakes; those
/// of `store` and of `cameras_at`; kTimeout: the disk takes nothing for a minute; kCancelled within a second, or when
/// the picture that is being stored is.
Result<AcquisitionOutcome> Acquire(const AcquisitionDevices& devices, const AcquisitionPlan& plan,
                                   const StorePicture& store,
                                   const std::function<void(const AcquisitionProgress&)>& listener,
                                   const std::stop_token& stop);

}  // namespace rigcal
