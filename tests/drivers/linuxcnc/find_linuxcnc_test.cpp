#include <gmock/gmock.h>

#include "drivers/linuxcnc/find_linuxcnc_devices.h"
#include "tests/drivers/linuxcnc/linuxcnc_peer.h"

namespace rigcal {
namespace {

using sim::LinuxcncMachine;
using ::testing::HasSubstr;

class FindLinuxcnc : public ::testing::Test {
 protected:
  Result<std::optional<FoundDevice>> Find() {
    return FindLinuxcncDeviceAt(peer_.Simulator().Address(), peer_.Time(), {});
  }
  std::string State() {
    const auto found = Find();
    return found && *found ? (*found)->state : "none";
  }

  LinuxcncPeer peer_;
};

TEST_F(FindLinuxcnc, SaysItsState) {
  const auto found = Find();
  ASSERT_TRUE(found && *found);
  EXPECT_EQ((*found)->driver, "linuxcnc");
  EXPECT_EQ((*found)->kind, DeviceKind::kPositioner);
  EXPECT_EQ((*found)->address, peer_.Simulator().Address());
  EXPECT_EQ((*found)->model, "LinuxCNC");
  EXPECT_EQ((*found)->firmware, "linuxcncrsh 1.1");
  EXPECT_EQ((*found)->state, "power off");
  EXPECT_EQ((*found)->problem, "");
  const auto device = peer_.Open();
  ASSERT_TRUE(device && (*device)->Home({}));
  EXPECT_EQ(State(), "idle");
}

TEST_F(FindLinuxcnc, AnEmergencyStopIsAProblem) {
  peer_.With([](LinuxcncMachine& machine) { machine.SetEmergencyStop(true, false); });
  const auto found = Find();
  ASSERT_TRUE(found && *found);
  EXPECT_EQ((*found)->state, "emergency stop");
  EXPECT_THAT((*found)->problem, HasSubstr("reset"));
}

TEST_F(FindLinuxcnc, WhoHasControlKeepsItAndTheMachineGoesOn) {
  const auto device = peer_.Open();
  ASSERT_TRUE(device && (*device)->Home({}));
  std::string during;
  peer_.Time().After(0.3, [&] { during = State(); });
  const Result<RecordedStop> moved = (*device)->MoveTo({"stop", peer_.Place(0)}, {});
  EXPECT_TRUE(moved) << moved.error().message;
  EXPECT_EQ(during, "moving");
}

TEST_F(FindLinuxcnc, NothingIsThereWhereNothingListens) {
  std::string address;
  {
    LinuxcncPeer gone;
    address = gone.Simulator().Address();
  }
  const auto found = FindLinuxcncDeviceAt(address, peer_.Time(), {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_FALSE(*found);
  EXPECT_EQ(FindLinuxcncDeviceAt("nowhere", peer_.Time(), {}).error().code, ErrorCode::kBadInput);
}

}  // namespace
}  // namespace rigcal
