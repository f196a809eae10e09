#include "config/check_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/config/example_rig.h"
#include "tests/config/refusals.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const Rigid3d kAboutFace{Eigen::Quaterniond(0, 0, 1, 0), Eigen::Vector3d::Zero()};  // half a turn about the camera's y

TEST(CheckViews, RingThatLooksInwardsIsFine) {
  for (int num_views : {3, 16}) EXPECT_EQ(Message(CheckViewsMeet(ExampleRing(num_views))), kNoError);
}

TEST(CheckViews, RoughPosesAreFine) {
  Random random(2);
  for (int run = 0; run < 50; ++run) {
    RigCalibration ring = ExampleRing(12);
    for (View& view : ring.views) {
      Eigen::Matrix<double, 6, 1> delta;
      for (int i = 0; i < 6; ++i) delta[i] = 0.03 * random.Normal();
      view.cam_from_world = Disturbed(view.cam_from_world, delta);
    }
    EXPECT_EQ(Message(CheckViewsMeet(ring)), kNoError);
  }
}

TEST(CheckViews, OneCameraThatLooksAwayIsNamed) {
  RigCalibration ring = ExampleRing(8);
  ring.views[3].cam_from_world = kAboutFace * ring.views[3].cam_from_world;
  EXPECT_THAT(Message(CheckViewsMeet(ring)), AllOf(HasSubstr("1 of 8"), HasSubstr("'ring_03.png'")));
}

TEST(CheckViews, AllCamerasLookAway) {
  RigCalibration ring = ExampleRing(8);
  for (View& view : ring.views) view.cam_from_world = kAboutFace * view.cam_from_world;
  EXPECT_THAT(Message(CheckViewsMeet(ring)), AllOf(HasSubstr("8 of 8"), HasSubstr("and 5 more")));
}

/// Cameras side by side, 0.1 m apart, that look along +z or are turned about their y axis.
RigCalibration Row(const std::vector<double>& turn_rad) {
  RigCalibration row = ExampleRing(static_cast<int>(turn_rad.size()));
  for (std::size_t v = 0; v < turn_rad.size(); ++v) {
    const Eigen::Quaterniond rotation = ExpRotation(turn_rad[v] * Eigen::Vector3d::UnitY()).conjugate();
    row.views[v].cam_from_world = {rotation, rotation * Eigen::Vector3d(-0.1 * static_cast<double>(v), 0, 0)};
  }
  return row;
}

TEST(CheckViews, ParallelCamerasAreFine) {
  EXPECT_EQ(Message(CheckViewsMeet(Row({0, 0, 0, 0}))), kNoError);
  EXPECT_EQ(Message(CheckViewsMeet(Row({-0.01, 0, 0.01}))), kNoError);
}

TEST(CheckViews, ViewWithoutCommonVolumeIsNamed) {
  // 64 pixels at f = 33 px take in 88 degrees: turned by 100 degrees, the last one shares nothing with the others.
  std::vector<double> turn_rad(40, 0.0);
  turn_rad.back() = 1.75;
  EXPECT_THAT(Message(CheckViewsMeet(Row(turn_rad))),
              AllOf(HasSubstr("1 of 40 views"), HasSubstr("'ring_39.png'"), HasSubstr("no volume in common")));
}

TEST(CheckViews, CamerasInOnePlaceAreRefused) {
  RigCalibration ring = ExampleRing(4);
  for (View& view : ring.views) view.cam_from_world = ring.views[0].cam_from_world;
  EXPECT_THAT(Message(CheckViewsMeet(ring)), HasSubstr("same place"));
}

}  // namespace
}  // namespace rigcal
