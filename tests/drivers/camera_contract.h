#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/base/clock.h"
#include "core/scene/rig_devices.h"
#include "drivers/camera_device.h"

namespace rigcal {

/// What can be wrong with a camera or the way to it.
enum class CameraFault {
  kSilent,      ///< it answers, but pictures do not come
  kDamaged,     ///< pictures come with parts missing
  kGone,        ///< it does not answer at all
  kHeldByOther  ///< somebody else has opened it
};

/// The far side of a driver: the camera, or what plays it, with faults that can be switched. It must outlive the
/// devices that it opens.
class CameraPeer {
 public:
  virtual ~CameraPeer() = default;

  /// Time as the driver under test sees it, and how much later than told a wait may end by it: 0 for a fake clock.
  virtual Clock& Time() = 0;
  virtual double SlackS() const = 0;
  /// A token that is set when `seconds` from now have passed by that clock.
  virtual std::stop_token StopAfter(double seconds) = 0;

  virtual CameraSettings Settings() = 0;
  virtual Result<std::unique_ptr<CameraDevice>> Open() = 0;

  /// Puts before the camera what its shot with this number is to see; called before the shot.
  virtual void Arrange(int shot) = 0;
  /// The picture of that shot, from elsewhere than the driver: what the peer sent.
  virtual cv::Mat Expected(int shot) = 0;

  /// Why this peer cannot have the fault; nothing when it can.
  virtual std::optional<std::string> WhyNot(CameraFault fault) = 0;
  virtual void Set(CameraFault fault, bool on) = 0;
  /// kGone from now on, and no longer when `seconds` have passed.
  virtual void GoneFor(double seconds) = 0;
};

/// What acquisition relies on, of every camera driver. A driver's test file instantiates it with its peers; where one
/// cannot run, it makes none, and the tests are skipped.
class CameraContract : public ::testing::TestWithParam<std::function<std::unique_ptr<CameraPeer>()>> {
 protected:
  void SetUp() override;

  /// Opens the camera, which is well.
  std::unique_ptr<CameraDevice> Open();
  /// Makes ready and fires.
  Result<void> Shoot(CameraDevice& camera, int shot);
  /// Takes a picture and compares it with what the peer sent.
  void ExpectPicture(CameraDevice& camera, int shot);
  void ExpectCollected(CameraDevice& camera, int shot);

  std::unique_ptr<CameraPeer> peer_;
  std::uint64_t last_number_ = 0;
  bool any_picture_ = false;
};

}  // namespace rigcal
