#include "drivers/sim/sim_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "drivers/registry.h"
#include "tests/drivers/camera_contract.h"
#include "tests/drivers/positioner_contract.h"
#include "tests/support/fake_clock.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth_px = 96, kHeight_px = 72;
constexpr double kPlaceStep_rad = std::numbers::pi / 4;

RigHardware SmallRig() {
  RigHardware rig;
  rig.cameras = {{.id = "left", .driver = "sim"}, {.id = "right", .driver = "sim", .serial = "S2"}};
  rig.positioner = {.driver = "sim", .axes = {{.name = "table", .least = -1, .most = 7}}, .settle_s = 0};
  rig.sim = {.num_cameras = 2, .width_px = kWidth_px, .height_px = kHeight_px, .noise_sigma = 0};
  return rig;
}

/// A studio is made once; the devices of one test at a time use it.
struct SharedSim {
  FakeClock clock;
  std::shared_ptr<SimRig> rig;
  std::optional<sim::Studio> reference;  ///< the same studio with stops, whose views are rendered without the driver
};

SharedSim& Shared() {
  static SharedSim* const shared = [] {
    auto* made = new SharedSim{};
    made->rig = *MakeSimRig(SmallRig(), {.clock = &made->clock}, {});
    made->reference =
        *sim::MakeStudio({.num_cameras = 2, .num_stops = 8, .width_px = kWidth_px, .height_px = kHeight_px}, {});
    return made;
  }();
  return *shared;
}

/// What is before the reference's camera at one of its stops, exposed without noise.
cv::Mat Reference(int camera, int stop) {
  const auto view = sim::RenderView(*Shared().reference, camera * 8 + stop, sim::ShotOptions().samples_per_side, {});
  return sim::Expose(view->radiance, {.noise_sigma = 0, .linear = true}, 0);
}

class SimCameraPeer final : public CameraPeer {
 public:
  SimCameraPeer() {
    Shared().rig->SetFaults(kCamera, {});
    Shared().rig->Table().SetFaults({});
  }
  ~SimCameraPeer() override { Set(CameraFault::kHeldByOther, false); }

  Clock& Time() override { return Shared().clock; }
  double SlackS() const override { return 0; }
  std::stop_token StopAfter(double seconds) override { return Shared().clock.StopAfter(seconds); }
  CameraSettings Settings() override { return SmallRig().cameras[kCamera]; }
  Result<std::unique_ptr<CameraDevice>> Open() override {
    return DriverOf(Shared().rig, SmallRig())->OpenCamera(Settings(), {});
  }
  void Arrange(int shot) override {
    constexpr double kAtOnce_rad_s = 1e9, kMoment_s = 1e-6;
    Shared().rig->Table().Start(shot * kPlaceStep_rad, kAtOnce_rad_s);
    Shared().clock.Advance(kMoment_s);
  }
  cv::Mat Expected(int shot) override { return Reference(kCamera, shot); }

  std::optional<std::string> WhyNot(CameraFault /*fault*/) override { return std::nullopt; }
  void Set(CameraFault fault, bool on) override {
    SimCameraFaults faults = Shared().rig->Faults(kCamera);
    if (fault == CameraFault::kSilent) faults.silent = on;
    if (fault == CameraFault::kDamaged) faults.damaged = on;
    if (fault == CameraFault::kGone) faults.gone = on;
    if (fault == CameraFault::kHeldByOther) other_.reset();
    if (fault == CameraFault::kHeldByOther && on) other_ = *Open();
    Shared().rig->SetFaults(kCamera, faults);
  }
  void GoneFor(double seconds) override {
    Set(CameraFault::kGone, true);
    Shared().clock.After(seconds, [] { Shared().rig->SetFaults(kCamera, {}); });
  }

 private:
  static constexpr int kCamera = 1;
  std::unique_ptr<CameraDevice> other_;
};

INSTANTIATE_TEST_SUITE_P(Sim, CameraContract,
                         ::testing::Values([] { return std::unique_ptr<CameraPeer>(new SimCameraPeer); }));

class SimPositionerPeer final : public PositionerPeer {
 public:
  SimPositionerPeer() {
    Shared().rig->Table().Halt();
    Shared().rig->Table().SetFaults({});
  }

  Clock& Time() override { return Shared().clock; }
  double SlackS() const override { return 0; }
  std::stop_token StopAfter(double seconds) override { return Shared().clock.StopAfter(seconds); }
  PositionerSettings Settings() override { return SmallRig().positioner; }
  Result<std::unique_ptr<PositionerDevice>> Open() override {
    return DriverOf(Shared().rig, SmallRig())->OpenPositioner(Settings(), {});
  }
  std::vector<double> Place(int number) override { return {(1 + number) * kPlaceStep_rad}; }
  std::vector<double> Position() override { return {Shared().rig->Table().Angle()}; }
  bool Moving() override { return Shared().rig->Table().Moving(); }

  std::optional<std::string> WhyNot(PositionerFault /*fault*/) override { return std::nullopt; }
  void Set(PositionerFault fault, bool on) override {
    SimTableFaults faults = Shared().rig->Table().Faults();
    if (fault == PositionerFault::kHoming) faults.no_home = on;
    if (fault == PositionerFault::kAlarm) faults.alarm = on;
    if (fault == PositionerFault::kGone) faults.gone = on;
    if (fault == PositionerFault::kStuck) faults.stuck = on;
    if (fault == PositionerFault::kOffTarget) faults.miss_rad = on ? 0.01 : 0;
    if (fault == PositionerFault::kPushed) Shared().rig->Table().Start(6, 1e-3);
    if (fault == PositionerFault::kException) {
      Shared().clock.After(0.3, [] { throw std::runtime_error("in the middle of a move"); });
    }
    Shared().rig->Table().SetFaults(faults);
  }
};

INSTANTIATE_TEST_SUITE_P(Sim, PositionerContract,
                         ::testing::Values([] { return std::unique_ptr<PositionerPeer>(new SimPositionerPeer); }));

TEST(SimDriver, AnAttemptChangesTheNoiseAndNothingElse) {
  FakeClock clock;
  RigHardware rig = SmallRig();
  rig.sim.noise_sigma = 2;
  const auto sim = MakeSimRig(rig, {.clock = &clock}, {});
  ASSERT_TRUE(sim);
  const cv::Mat first = *(*sim)->Picture(0, kPlaceStep_rad, 0, 8, {});
  const cv::Mat again = *(*sim)->Picture(0, kPlaceStep_rad, 0, 8, {});
  const cv::Mat retake = *(*sim)->Picture(0, kPlaceStep_rad, 1, 8, {});
  EXPECT_EQ(cv::norm(first, again, cv::NORM_INF), 0);
  const double rms = cv::norm(first, retake, cv::NORM_L2) / std::sqrt(static_cast<double>(first.total()));
  EXPECT_NEAR(rms, 2 * std::sqrt(2.0), 1.0);  // of two independent noises, cut off where it is dark
}

TEST(SimDriver, ApproachesAStopFromItsSideWithTheBacklash) {
  SimPositionerPeer peer;
  PositionerSettings settings = SmallRig().positioner;
  settings.axes.front().approach = 1;
  settings.axes.front().backlash = 0.1;
  const auto positioner = DriverOf(Shared().rig, SmallRig())->OpenPositioner(settings, {});
  ASSERT_TRUE(positioner);
  ASSERT_TRUE((*positioner)->MoveTo({"a", {2}}, {}));
  double lowest_rad = 2;
  for (int i = 1; i < 100; ++i) {
    Shared().clock.After(0.05 * i, [&] { lowest_rad = std::min(lowest_rad, Shared().rig->Table().Angle()); });
  }
  ASSERT_TRUE((*positioner)->MoveTo({"b", {1}}, {}));
  EXPECT_EQ(Shared().rig->Table().Angle(), 1);
  EXPECT_NEAR(lowest_rad, 0.9, 1e-9);
  Shared().clock.Advance(10);
}

TEST(Registry, OpensARigInItsOrder) {
  FakeClock clock;
  Result<OpenedRig> opened = OpenRig(SmallRig(), {.clock = &clock}, {});
  ASSERT_TRUE(opened) << opened.error().message;
  ASSERT_EQ(opened->cameras.size(), 2);
  EXPECT_EQ(opened->cameras[1]->Identity().id, "right");
  EXPECT_NE(opened->positioner, nullptr);
  EXPECT_FALSE(opened->real);
}

TEST(Registry, RefusesADriverThatItHasNot) {
  FakeClock clock;
  RigHardware rig = SmallRig();
  rig.cameras[0].driver = "webcam";
  const Result<OpenedRig> opened = OpenRig(rig, {.clock = &clock}, {});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kBadInput);
  EXPECT_THAT(opened.error().message, HasSubstr("camera 'left': there is no driver 'webcam'"));
}

TEST(SimDriver, AChartToBeSeenIsABoardOnTheTable) {
  FakeClock clock;
  DriverContext context{.clock = &clock, .subject = Subject::kChart};
  const auto without = MakeSimRig(SmallRig(), context, {});
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().code, ErrorCode::kBadInput);
  context.board = Board{.family = "tag36h11", .columns = 2, .rows = 2, .tag_m = 0.05, .gap_m = 0.02};
  const auto with = MakeSimRig(SmallRig(), context, {});
  ASSERT_TRUE(with) << with.error().message;
  const Result<cv::Mat> picture = (*with)->Picture(0, 0, 0, 8, {});
  ASSERT_TRUE(picture);
  EXPECT_GT(cv::norm(*picture, Reference(0, 0), cv::NORM_INF), 50) << "the object is still there";
}

TEST(SimDriver, RefusesMoreCamerasThanTheStudioHas) {
  RigHardware rig = SmallRig();
  rig.cameras.push_back({.id = "third", .driver = "sim"});
  const auto camera = DriverOf(Shared().rig, rig)->OpenCamera(rig.cameras.back(), {});
  ASSERT_FALSE(camera);
  EXPECT_EQ(camera.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace rigcal
