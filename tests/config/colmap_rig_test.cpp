#include "config/formats/colmap_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/config/export_examples.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;

/// Every view is in one frame, of the rig of its camera, and has the pose that frame and rig give it.
void ExpectWhole(const RigCalibration& studio, const ColmapRigs& rigs) {
  std::vector<int> frames_of_view(studio.views.size());
  for (const ColmapFrame& frame : rigs.frames) {
    const ColmapRig& rig = rigs.rigs[frame.rig];
    for (int v : frame.views) {
      ++frames_of_view[v];
      const auto place =
          std::find(rig.cameras.begin(), rig.cameras.end(), studio.views[v].camera) - rig.cameras.begin();
      ASSERT_LT(place, std::ssize(rig.cameras));
      const Rigid3d cam_from_world = rig.sensor_from_rig[place] * frame.rig_from_world;
      EXPECT_LT(cam_from_world.rotation.angularDistance(studio.views[v].cam_from_world.rotation), 1e-9);
      EXPECT_LT((cam_from_world.translation - studio.views[v].cam_from_world.translation).norm(), 1e-9);
    }
  }
  EXPECT_THAT(frames_of_view, ::testing::Each(1));
}

TEST(ColmapRig, AStopIsAFrame) {
  const RigCalibration studio = ExampleStudio();
  const auto rigs = ColmapRigsOf(studio);
  ASSERT_TRUE(rigs);
  ASSERT_EQ(rigs->rigs.size(), 1U);
  EXPECT_THAT(rigs->rigs[0].cameras, ElementsAre(0, 1, 2));
  ASSERT_EQ(rigs->frames.size(), 4U);
  EXPECT_THAT(rigs->frames[1].views, ElementsAre(3, 4, 5));
  ExpectWhole(studio, *rigs);
}

TEST(ColmapRig, AViewThatIsNotWhereItsRigIsKeepsItsPose) {
  RigCalibration studio = ExampleStudio();
  studio.views[4].cam_from_world.translation.x() += 1e-6;
  const auto rigs = ColmapRigsOf(studio);
  ASSERT_TRUE(rigs);
  EXPECT_EQ(rigs->frames.size(), 5U);
  ExpectWhole(studio, *rigs);
}

TEST(ColmapRig, TwoPicturesOfOneCameraAreTwoFrames) {
  RigCalibration studio = ExampleStudio();
  studio.views.push_back(studio.views[0]);
  studio.views.back().name = "again.png";
  const auto rigs = ColmapRigsOf(studio);
  ASSERT_TRUE(rigs);
  EXPECT_EQ(rigs->frames.size(), 5U);
  ExpectWhole(studio, *rigs);
}

TEST(ColmapRig, ACameraWithoutAPlaceIsARigOfItsOwn) {
  RigCalibration studio = ExampleStudio();
  studio.rig->model.cam_from_mount[0].reset();
  const auto rigs = ColmapRigsOf(studio);
  ASSERT_TRUE(rigs);
  ASSERT_EQ(rigs->rigs.size(), 2U);
  EXPECT_THAT(rigs->rigs[0].cameras, ElementsAre(0));
  EXPECT_THAT(rigs->rigs[1].cameras, ElementsAre(1, 2));
  EXPECT_EQ(rigs->frames.size(), 8U);
  ExpectWhole(studio, *rigs);
}

TEST(ColmapRig, NothingWithoutARigOfSeveralCameras) {
  RigCalibration studio = ExampleStudio();
  studio.rig->model.cam_from_mount = {std::nullopt, Rigid3d(), std::nullopt};
  EXPECT_FALSE(ColmapRigsOf(studio));
  studio.rig.reset();
  EXPECT_FALSE(ColmapRigsOf(studio));
}

}  // namespace
}  // namespace rigcal
