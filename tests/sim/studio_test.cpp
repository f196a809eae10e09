#include "sim_fixtures/studio.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "sim_fixtures/mesh.h"
#include "sim_fixtures/noise.h"
#include "sim_fixtures/truth_file.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

StudioOptions Small(Scene scene) {
  StudioOptions options;
  options.scene = scene;
  options.cell_m = 0.002;
  options.width_px = 640;
  options.height_px = 480;
  return options;
}

TEST(MakeStudio, TableTurnsCounterClockwiseSeenFromAbove) {
  StudioOptions options = Small(Scene::kTextured);
  options.num_stops = 4;
  const auto studio = MakeStudio(options, {});
  ASSERT_TRUE(studio.has_value());
  // After a quarter turn what was at +x of the studio is at +y.
  const Vector3d turned = studio->stage_from_world[1] * Vector3d(1, 0, 0);
  EXPECT_LT((turned - Vector3d(0, 1, 0)).norm(), 1e-12);
  // The camera stands still in the studio.
  const auto& views = studio->truth.views;
  const Rigid3d first = views[0].cam_from_world * studio->stage_from_world[0].Inverse();
  const Rigid3d second = views[1].cam_from_world * studio->stage_from_world[1].Inverse();
  EXPECT_LT((first.translation - second.translation).norm(), 1e-12);
  EXPECT_LT(first.rotation.angularDistance(second.rotation), 1e-7);
}

TEST(MakeStudio, StepErrorsComeFromTheSeed) {
  StudioOptions options = Small(Scene::kMarker);
  options.num_stops = 100;
  options.step_error_deg = 0.1;
  const auto once = MakeStudio(options, {}), again = MakeStudio(options, {});
  options.random_seed = 2;
  const auto other = MakeStudio(options, {});
  double sum = 0;
  for (int stop = 1; stop < options.num_stops; ++stop) {
    const double error_deg = once->table_angle_rad[stop] * 180 / std::numbers::pi - 360.0 * stop / options.num_stops;
    sum += error_deg * error_deg;
  }
  EXPECT_NEAR(std::sqrt(sum / (options.num_stops - 1)), 0.1, 0.03);
  EXPECT_EQ(once->table_angle_rad, again->table_angle_rad);
  EXPECT_NE(once->table_angle_rad, other->table_angle_rad);
}

TEST(MakeStudio, ObjectFillsThePicturesAndPixelsAreSquare) {
  for (const Motion motion : {Motion::kTurntable, Motion::kGantry}) {
    StudioOptions options = Small(Scene::kThin);
    options.motion = motion;
    options.num_cameras = motion == Motion::kTurntable ? 3 : 1;
    options.num_stops = 6;
    const auto studio = MakeStudio(options, {});
    ASSERT_TRUE(studio.has_value());
    double tallest = 0;
    for (int view = 0; view < studio->truth.NumViews(); ++view) {
      const Camera& camera = studio->truth.CameraOf(view);
      EXPECT_EQ(camera.fx_px, camera.fy_px);
      Eigen::AlignedBox2d box;
      for (const auto& x : studio->rays.Meshes()[kObjectMesh].vertices_in_world) {
        box.extend(*Project(camera, studio->truth.views[view].cam_from_world * x.cast<double>()));
      }
      EXPECT_GT(box.min().minCoeff(), 0);
      EXPECT_LT(box.max().x(), camera.width_px - 1);
      EXPECT_LT(box.max().y(), camera.height_px - 1);
      tallest = std::max(tallest, box.sizes().y());
    }
    EXPECT_GT(tallest, 0.7 * options.height_px);
  }
}

TEST(MakeStudio, RefusesOptionsOutOfRangeAndNamesTheLimit) {
  StudioOptions options = Small(Scene::kTextured);
  options.num_stops = 0;
  EXPECT_THAT(MakeStudio(options, {}).error().message, HasSubstr("stops is 0, must lie within 1 .. 720"));
  options = Small(Scene::kTextured);
  options.step_error_deg = std::nan("");
  EXPECT_THAT(MakeStudio(options, {}).error().message, HasSubstr("step-error-deg"));
  options = Small(Scene::kTextured);
  options.distortion = {-12, 0, 0, 0, 0};
  EXPECT_THAT(MakeStudio(options, {}).error().message, HasSubstr("k1 = -12"));
}

TEST(TruthFile, MakesTheSameStudioAgain) {
  StudioOptions options = Small(Scene::kPlaster);
  options.num_stops = 5;
  options.step_error_deg = 0.05;
  options.distortion = {-0.1, 0.02, 0.001, 0, 0};
  const auto studio = MakeStudio(options, {});
  const std::string text = TruthText(*studio, {});
  const auto again = StudioFromTruth(text, "truth.json", {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(TruthText(*again, {}), text);
}

TEST(TruthFile, NamesWhatIsWrong) {
  EXPECT_THAT(StudioFromTruth("{", "a.json", {}).error().message, HasSubstr("a.json: is not JSON"));
  EXPECT_THAT(StudioFromTruth("{}", "a.json", {}).error().message, HasSubstr("studio"));
  const auto studio = MakeStudio(Small(Scene::kMarker), {});
  nlohmann::json moved = nlohmann::json::parse(TruthText(*studio, {}));
  moved["views"][0]["cam_from_world"]["translation_m"][0] = 7;
  EXPECT_THAT(StudioFromTruth(moved.dump(), "a.json", {}).error().message, HasSubstr("a.json: its poses differ"));
}

TEST(MeshOf, IsClosedAndFacesOutwards) {
  for (const Scene scene : {Scene::kTextured, Scene::kPlaster, Scene::kThin}) {
    const TriangleMesh mesh = MeshOf(ShapeOf(scene), 0.0015, {});
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    std::size_t outwards = 0;
    for (const auto& t : mesh.triangles) {
      for (int i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
      const Eigen::Vector3f facet = (mesh.vertices_in_world[t[1]] - mesh.vertices_in_world[t[0]])
                                        .cross(mesh.vertices_in_world[t[2]] - mesh.vertices_in_world[t[0]]);
      outwards += facet.dot(mesh.normals_in_world[t[0]]) > 0 ? 1 : 0;
    }
    std::size_t open = 0;
    for (const auto& [edge, count] : edges) {
      const auto opposite = edges.find({edge.second, edge.first});
      open += opposite == edges.end() || opposite->second != count ? 1 : 0;
    }
    EXPECT_EQ(open, 0U) << NameOf(scene);
    EXPECT_GT(static_cast<double>(outwards), 0.98 * static_cast<double>(mesh.triangles.size())) << NameOf(scene);
  }
}

TEST(MeshOf, VerticesLieOnTheSurface) {
  const TriangleMesh mesh = MeshOf(ShapeOf(Scene::kMarker), 0.0003, {});
  for (const auto& x : mesh.vertices_in_world) {
    EXPECT_NEAR((x.cast<double>() - kMarkerCentreInWorld_m).norm(), kMarkerRadius_m, 1e-8);
  }
}

TEST(Noise, HasUnitDeviationAndDependsOnThePlaceAlone) {
  const FractalNoise noise{.longest_m = 0.01f, .num_octaves = 4, .gain = 0.7f, .seed = 3};
  constexpr int kCount = 100'003;
  std::vector<float> x(kCount), y(kCount), z(kCount), values(kCount);
  for (int i = 0; i < kCount; ++i) {
    const auto step = static_cast<float>(i);
    x[i] = -0.5f + 1e-5f * step, y[i] = 0.37e-5f * step - 0.1f, z[i] = 0.71e-5f * step;
  }
  EvaluateNoise(noise, {x, y, z}, values);
  double sum = 0, squares = 0;
  for (const float value : values) sum += value, squares += value * value;
  EXPECT_NEAR(sum / kCount, 0, 0.1);
  EXPECT_NEAR(squares / kCount, 1, 0.15);
  for (int i = 0; i < kCount; i += 997) EXPECT_EQ(NoiseAt(noise, x[i], y[i], z[i]), values[i]);
}

}  // namespace
}  // namespace rigcal::sim
