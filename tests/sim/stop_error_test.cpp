#include "sim_fixtures/stop_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "core/rig/rig_model_pose.h"
#include "sim_fixtures/truth_file.h"

namespace rigcal::sim {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kDegree = std::numbers::pi / 180;

StudioOptions Table(int num_stops) {
  StudioOptions options;
  options.scene = Scene::kMarker;
  options.cell_m = 0.001;
  options.num_stops = num_stops;
  options.num_cameras = 2;
  return options;
}

Studio MakeOrDie(const StudioOptions& options) {
  auto studio = MakeStudio(options, {});
  EXPECT_TRUE(studio.has_value()) << studio.error().message;
  return std::move(*studio);
}

void ExpectSame(const Rigid3d& a, const Rigid3d& b) {
  EXPECT_LT((a.rotation.coeffs() - b.rotation.coeffs()).norm(), 1e-15);
  EXPECT_LT((a.translation - b.translation).norm(), 1e-15);
}

TEST(StageFromWorld, IsTheMotionOfTheRigModel) {
  Random random(7);
  const RigModel rig = Turntable();
  for (int i = 0; i < 20; ++i) {
    StopError error;
    for (int k = 0; k < kStopErrorSize; ++k) error[k] = 0.02 * random.Normal();
    if (i % 3 == 0) error = error.cwiseProduct(StopError::Unit(kStep));
    const double angle_rad = random.Uniform(-3, 3);
    const StopMotion motion = MotionAt(rig.positioner, {"", {angle_rad}, {}}, error);
    ExpectSame(StageFromWorld(angle_rad, error), motion.stage_from_world);
  }
}

TEST(MakeStudio, PosesFollowTheRigModel) {
  StudioOptions options = Table(5);
  options.step_error_deg = 0.3, options.wobble_deg = 0.2, options.run_out_mm = 0.1;
  options.slips = {{2, 1.5}};
  options.bumps = {{1, 2}};
  const Studio studio = MakeOrDie(options);
  const RigModel rig = Turntable();
  for (int v = 0; v < studio.truth.NumViews(); ++v) {
    const int stop = studio.stop[v];
    const StopMotion motion =
        MotionAt(rig.positioner, {"", {studio.commanded_rad[stop]}, {}}, studio.stop_errors[stop]);
    ExpectSame(studio.stage_from_world[v], motion.stage_from_world);
    ExpectSame(studio.truth.views[v].cam_from_world,
               CamFromWorld(studio.cam_from_stage[studio.truth.views[v].camera], motion));
  }
  const auto again = StudioFromTruth(TruthText(studio, {}), "truth.json", {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(TruthText(*again, {}), TruthText(studio, {}));
}

TEST(DrawStopErrors, HaveTheirSigmasAndEachItsOwnNumbers) {
  StudioOptions options = Table(400);
  options.step_error_deg = 0.1;
  const std::vector<StopError> steps = DrawStopErrors(options);
  options.wobble_deg = 0.2, options.run_out_mm = 0.05;
  const std::vector<StopError> all = DrawStopErrors(options);
  StopError squares = StopError::Zero();
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i][kStep], steps[i][kStep]);
    squares += all[i].cwiseAbs2() / static_cast<double>(all.size());
  }
  StopError sigma;
  sigma << 0.2 * kDegree, 0.2 * kDegree, 0.1 * kDegree, 5e-5, 5e-5, 0;
  for (int k = 0; k < kStopErrorSize; ++k) EXPECT_NEAR(std::sqrt(squares[k]), sigma[k], 0.1 * sigma[k]) << k;
}

TEST(DrawStopErrors, ASlipIsOfItsStopAlone) {
  StudioOptions options = Table(5);
  options.step_error_deg = 0.1;
  const std::vector<StopError> before = DrawStopErrors(options);
  options.slips = {{3, -2}};
  const std::vector<StopError> after = DrawStopErrors(options);
  for (int stop = 0; stop < 5; ++stop) {
    EXPECT_NEAR(after[stop][kStep] - before[stop][kStep], stop == 3 ? -2 * kDegree : 0, 1e-15);
  }
}

TEST(MakeStudio, ABumpTurnsItsCameraAboutItself) {
  StudioOptions options = Table(3);
  const Studio before = MakeOrDie(options);
  options.bumps = {{1, 0.5}};
  const Studio after = MakeOrDie(options);
  ExpectSame(after.cam_from_stage[0], before.cam_from_stage[0]);
  const Rigid3d turn = after.cam_from_stage[1] * before.cam_from_stage[1].Inverse();
  EXPECT_NEAR(LogRotation(turn.rotation).norm(), 0.5 * kDegree, 1e-12);
  EXPECT_LT(turn.translation.norm(), 1e-12);
}

TEST(MakeStudio, APixelBumpMovesThePicturesOfTheObjectBySoMuch) {
  StudioOptions options = Table(4);
  options.random_seed = 5;
  const Studio before = MakeOrDie(options);
  options.pixel_bumps = {{1, 0.3}};
  const Studio after = MakeOrDie(options);
  ExpectSame(after.cam_from_stage[0], before.cam_from_stage[0]);
  double sum_px = 0;
  int count = 0;
  for (int v = 0; v < before.truth.NumViews(); ++v) {
    if (before.truth.views[v].camera != 1) continue;
    for (const auto& x : before.rays.Meshes()[kObjectMesh].vertices_in_world) {
      const Eigen::Vector3d x_in_world = x.cast<double>();
      sum_px += (*Project(after.truth.CameraOf(v), after.truth.views[v].cam_from_world * x_in_world) -
                 *Project(before.truth.CameraOf(v), before.truth.views[v].cam_from_world * x_in_world))
                    .norm();
      ++count;
    }
  }
  EXPECT_NEAR(sum_px / count, 0.3, 0.03);
  EXPECT_LT((after.cam_from_stage[1] * before.cam_from_stage[1].Inverse()).translation.norm(), 1e-12);
  const auto again = StudioFromTruth(TruthText(after, {}), "truth.json", {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(TruthText(*again, {}), TruthText(after, {}));
}

TEST(MakeStudio, AnotherObjectStandsUnderTheSameCameras) {
  StudioOptions options = Table(2);
  options.scene = Scene::kTextured;
  options.cell_m = 0.002;
  const Studio figurine = MakeOrDie(options);
  options.object = Scene::kMarker;
  const Studio marker = MakeOrDie(options);
  ExpectSame(marker.cam_from_stage[1], figurine.cam_from_stage[1]);
  EXPECT_LT(marker.rays.Meshes()[kObjectMesh].vertices_in_world.size(),
            figurine.rays.Meshes()[kObjectMesh].vertices_in_world.size());
  options.object_variant = 3;
  const Studio variant = MakeOrDie(options);
  EXPECT_NE(variant.object.texture.seed, marker.object.texture.seed);
  // The sphere beside the axis stands elsewhere about it, at the same height and distance.
  const auto centre = [](const Studio& studio) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& x : studio.rays.Meshes()[kObjectMesh].vertices_in_world) sum += x.cast<double>();
    return Eigen::Vector3d(sum / static_cast<double>(studio.rays.Meshes()[kObjectMesh].vertices_in_world.size()));
  };
  EXPECT_NEAR(centre(variant).z(), centre(marker).z(), 1e-4);
  EXPECT_NEAR(centre(variant).head<2>().norm(), centre(marker).head<2>().norm(), 1e-4);
  EXPECT_GT((centre(variant) - centre(marker)).norm(), 0.01);
  const auto again = StudioFromTruth(TruthText(variant, {}), "truth.json", {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(TruthText(*again, {}), TruthText(variant, {}));
}

// Sets that were made before tables wobbled: the same angles, by the same arithmetic, and a truth.json of the same
// keys.
TEST(MakeStudio, UnusedOptionsLeaveNoTrace) {
  StudioOptions options = Table(4);
  options.step_error_deg = 0.1;
  const Studio studio = MakeOrDie(options);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(studio.table_angle_rad[3], Eigen::Vector3d::UnitZ()));
  EXPECT_EQ(studio.stage_from_world[3].rotation.coeffs(), turn.coeffs());
  const std::string text = TruthText(studio, {});
  for (const char* key :
       {"wobble", "run_out", "bumps", "slips", "stop_errors", "commanded", "chart", "object_variant"}) {
    EXPECT_THAT(text, Not(HasSubstr(key)));
  }
}

TEST(MakeStudio, RefusesErrorsAndFaultsThatCannotBe) {
  const auto message = [](auto&& change) {
    StudioOptions options = Table(4);
    change(options);
    return MakeStudio(options, {}).error().message;
  };
  EXPECT_THAT(message([](StudioOptions& o) { o.wobble_deg = 6; }),
              HasSubstr("wobble-deg is 6, must lie within 0 .. 5"));
  EXPECT_THAT(message([](StudioOptions& o) { o.run_out_mm = std::nan(""); }), HasSubstr("run-out-mm"));
  EXPECT_THAT(message([](StudioOptions& o) {
                o.bumps = {{2, 1}};
              }),
              HasSubstr("bump's camera is 2, must lie within 0 .. 1"));
  EXPECT_THAT(message([](StudioOptions& o) {
                o.slips = {{4, 1}};
              }),
              HasSubstr("slip's stop is 4, must lie within 0 .. 3"));
  EXPECT_THAT(message([](StudioOptions& o) { o.bumps = {{1, 30}}; }), HasSubstr("bump's angle (deg) is 30"));
  EXPECT_THAT(message([](StudioOptions& o) {
                o.motion = Motion::kGantry, o.num_cameras = 1;
                o.slips = {{1, 1}};
              }),
              HasSubstr("turntable"));
}

}  // namespace
}  // namespace rigcal::sim
