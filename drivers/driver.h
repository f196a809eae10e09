#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "core/scene/board.h"
#include "core/scene/rig_devices.h"
#include "drivers/camera_device.h"
#include "drivers/positioner_device.h"

namespace rigcal {

/// Everything of a rig file that devices are opened from.
struct RigHardware {
  std::vector<CameraSettings> cameras;
  PositionerSettings positioner;
  SimSettings sim;        ///< for the driver "sim"
  ReplaySettings replay;  ///< for the driver "replay"
};

/// A recording with its pictures. Reading one is done elsewhere, drivers do not know its files.
struct RecordedPictures {
  Recording recording;
  /// The picture of a view: pixels, and the file that holds them. Errors name the file.
  std::function<Result<CapturedPicture>(int view)> load;
};

/// What devices get from whoever opens them.
struct DriverContext {
  Clock* clock = nullptr;  ///< outlives the devices
  Subject subject = Subject::kObject;
  std::optional<Board> board;  ///< the chart, for a simulated studio with Subject::kChart
  std::function<Result<RecordedPictures>(const std::string& folder)> open_recording;  ///< for replay
  std::function<void(const std::string& sentence)> tell;  ///< what whoever works with the rig should know; may be empty
  /// Asks him to do something and waits until he says that it is done; empty where nobody can be asked. Errors:
  /// kTimeout, kCancelled; kDevice: nobody is there any more.
  std::function<Result<void>(const std::string& what, double timeout_s, const std::stop_token& stop)> confirm;
};

/// One kind of hardware, for one rig: what its devices share lives here or is shared by them; they may outlive it.
class Driver {
 public:
  virtual ~Driver() = default;
  Driver() = default;
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  /// Finds and opens a device and sets it as its settings say. Errors: kNotFound, kDevice, kBadInput, kUnsupported,
  /// kCancelled.
  virtual Result<std::unique_ptr<CameraDevice>> OpenCamera(const CameraSettings& settings,
                                                           const std::stop_token& stop) = 0;
  virtual Result<std::unique_ptr<PositionerDevice>> OpenPositioner(const PositionerSettings& settings,
                                                                   const std::stop_token& stop) = 0;
};

/// How far from a target an axis may come to rest, radians or metres.
double ToleranceOf(const PositionerSettings& settings, const AxisSettings& axis);

/// Checks a target against the axes: as many finite values as axes, within the soft limits but for rounding. `device`
/// names it in messages. Errors: kBadInput.
Result<void> CheckTarget(const StopTarget& target, const std::vector<AxisSettings>& axes, const std::string& device);

/// Where the approach to a target begins: beyond it by the backlash, on the axes that come from the wrong side; the
/// target itself where none does. `from` is where the axes stand; `approached`: the last move ended from the side of
/// `approach`, otherwise the play lies on either side.
StopTarget BeginOfApproach(const StopTarget& target, const std::vector<double>& from,
                           const std::vector<AxisSettings>& axes, bool approached);

/// The stop as a recording has it, of a machine that rests `at`. Errors: kDevice: further from the target than the
/// tolerance.
Result<RecordedStop> ArrivedAt(const StopTarget& target, const std::vector<double>& at,
                               const PositionerSettings& settings, const std::string& device);

/// Errors: kDevice: the machine rested at `was`, stands `at` another place now, and was not told to go there.
Result<void> CheckUnmoved(const std::vector<double>& was, const std::vector<double>& at,
                          const PositionerSettings& settings, const std::string& device);

}  // namespace rigcal
