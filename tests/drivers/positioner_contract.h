#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/scene/rig_devices.h"
#include "drivers/positioner_device.h"

namespace rigcal {

/// What can be wrong with a positioner or the way to it.
enum class PositionerFault {
  kHoming,     ///< an axis does not find its zero
  kAlarm,      ///< it raises an alarm in the middle of the next move
  kGone,       ///< the connection is lost in the middle of the next move
  kStuck,      ///< it does not get on, without saying why
  kOffTarget,  ///< it ends elsewhere than it was told
  kPushed,     ///< it moves without having been told by the driver
  kException,  ///< waiting for the next move throws
};

/// The far side of a driver: the machine, or what plays it, with faults that can be switched. It must outlive the
/// devices that it opens.
class PositionerPeer {
 public:
  virtual ~PositionerPeer() = default;

  /// Time as the driver under test sees it, and how much later than told a wait may end by it: 0 for a fake clock.
  virtual Clock& Time() = 0;
  virtual double SlackS() const = 0;
  /// A token that is set when `seconds` from now have passed by that clock.
  virtual std::stop_token StopAfter(double seconds) = 0;

  virtual PositionerSettings Settings() = 0;
  virtual Result<std::unique_ptr<PositionerDevice>> Open() = 0;

  /// Places that the machine can go to, one for each number and a second of moving or more apart.
  virtual std::vector<double> Place(int number) = 0;
  /// Where it really is, one value for each axis, and whether it moves.
  virtual std::vector<double> Position() = 0;
  virtual bool Moving() = 0;

  /// Why this peer cannot have the fault; nothing when it can.
  virtual std::optional<std::string> WhyNot(PositionerFault fault) = 0;
  virtual void Set(PositionerFault fault, bool on) = 0;
};

/// What acquisition relies on, of every driver whose machine it moves. A driver's test file instantiates it with its
/// peers.
class PositionerContract : public ::testing::TestWithParam<std::function<std::unique_ptr<PositionerPeer>()>> {
 protected:
  void SetUp() override { peer_ = GetParam()(); }

  /// Opens and homes the machine, which is well.
  std::unique_ptr<PositionerDevice> OpenHomed();
  /// Goes to a place of the peer.
  Result<RecordedStop> Go(PositionerDevice& positioner, int place, const std::stop_token& stop = {});
  /// The next move ends with an Error of this code that names what it must, and the machine stands.
  void ExpectFailedMove(PositionerDevice& positioner, ErrorCode code);
  [[nodiscard]] bool Near(const std::vector<double>& a, const std::vector<double>& b) const;

  std::unique_ptr<PositionerPeer> peer_;
};

}  // namespace rigcal
