#include <gmock/gmock.h>

#include "drivers/grbl/find_grbl_devices.h"
#include "drivers/grbl/serial_line.h"
#include "sim_fixtures/grbl/grbl_simulator.h"
#include "tests/support/fake_clock.h"

namespace rigcal {
namespace {

using sim::GrblMachine;
using ::testing::HasSubstr;

class FindGrbl : public ::testing::Test {
 protected:
  FindGrbl() : simulator_(*sim::GrblSimulator::Start(clock_)) {}
  Result<std::optional<FoundDevice>> Find() { return FindGrblDeviceAt(simulator_->Path(), clock_, {}); }

  FakeClock clock_;
  std::unique_ptr<sim::GrblSimulator> simulator_;
};

TEST_F(FindGrbl, SaysVersionAndState) {
  simulator_->Push("$X\n");
  const auto found = Find();
  ASSERT_TRUE(found && *found);
  const FoundDevice& device = **found;
  EXPECT_EQ(device.driver, "grbl");
  EXPECT_EQ(device.kind, DeviceKind::kPositioner);
  EXPECT_EQ(device.address, simulator_->Path());
  EXPECT_EQ(device.model, "GRBL");
  EXPECT_EQ(device.firmware, "1.1h.20190825");
  EXPECT_EQ(device.state, "idle");
  EXPECT_EQ(device.problem, "");
}

TEST_F(FindGrbl, AnAlarmIsAProblemAndStays) {
  const auto found = Find();  // as it was switched on
  ASSERT_TRUE(found && *found);
  EXPECT_EQ((*found)->state, "alarm");
  EXPECT_THAT((*found)->problem, HasSubstr("alarm"));
  EXPECT_EQ((*found)->firmware, "1.1h.20190825");
  EXPECT_EQ((*Find())->state, "alarm");
}

TEST_F(FindGrbl, AMachineThatMovesGoesOn) {
  simulator_->Push("$X\n$J=G91X100F600\n");
  const auto found = Find();
  ASSERT_TRUE(found && *found);
  EXPECT_EQ((*found)->state, "jog");
  simulator_->With([](GrblMachine& machine) { EXPECT_TRUE(machine.Moving()); });
}

TEST_F(FindGrbl, ALineThatIsHeldIsNotAsked) {
  std::string log;
  simulator_->With([&](GrblMachine& machine) { machine.SetReceived(&log); });
  const Result<SerialLine> holder = SerialLine::Open(simulator_->Path());
  ASSERT_TRUE(holder);
  const auto found = Find();
  ASSERT_TRUE(found && *found);
  EXPECT_EQ((*found)->state, "held by another program");
  EXPECT_EQ((*found)->model, "");
  simulator_->With([](GrblMachine& machine) { machine.SetReceived(nullptr); });
  EXPECT_EQ(log, "");
}

TEST_F(FindGrbl, WhatIsSilentIsNone) {
  simulator_->With([](GrblMachine& machine) { machine.Faults().silent = true; });
  simulator_->WhenSilent([this] { clock_.Advance(10); });
  const auto found = Find();
  simulator_->WhenSilent({});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_FALSE(*found);
}

TEST_F(FindGrbl, NoSuchLineIsAnError) {
  EXPECT_EQ(FindGrblDeviceAt("/dev/ttyNowhere", clock_, {}).error().code, ErrorCode::kNotFound);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(FindGrblDeviceAt(simulator_->Path(), clock_, stop.get_token()).error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace rigcal
