#include "tests/config/export_examples.h"

#include <fmt/format.h>

#include "core/rig/rig_model_pose.h"

namespace rigcal {
namespace {

Camera ExampleCamera(const std::string& id, int width_px, int height_px) {
  Camera camera;
  camera.id = camera.physical_id = id;
  camera.width_px = width_px, camera.height_px = height_px;
  camera.fx_px = 900 + 1.0 / 3, camera.fy_px = 903 - 1.0 / 7;
  camera.cx_px = 0.5 * width_px + 11 + 1.0 / 3, camera.cy_px = 0.5 * height_px - 7 - 1.0 / 7;
  return camera;
}

/// A camera in the studio that looks at the table's middle from `centre`.
Rigid3d LookingAtTheTable(const Eigen::Vector3d& centre_in_stage) {
  Eigen::Matrix3d stage_from_cam;
  stage_from_cam.col(2) = -centre_in_stage.normalized();
  stage_from_cam.col(0) = stage_from_cam.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  stage_from_cam.col(1) = stage_from_cam.col(2).cross(stage_from_cam.col(0));
  return Rigid3d{Eigen::Quaterniond(stage_from_cam).normalized(), centre_in_stage}.Inverse();
}

void MakeRadial(Camera& camera) {
  camera.fy_px = camera.fx_px;
  camera.cx_px = 0.5 * (camera.width_px - 1), camera.cy_px = 0.5 * (camera.height_px - 1);
  camera.p1 = camera.p2 = camera.k3 = 0;
}

template <typename Change>
RigCalibration Changed(RigCalibration studio, Change change) {
  for (Camera& camera : studio.cameras) change(camera);
  return studio;
}

}  // namespace

RigCalibration ExampleStudio() {
  RigCalibration studio;
  studio.unit = LengthUnit::kMetre;
  studio.cameras = {ExampleCamera("left", 641, 480), ExampleCamera("right", 640, 481), ExampleCamera("top", 479, 642)};
  for (Camera* camera : {&studio.cameras[0], &studio.cameras[1]})
    camera->k1 = -0.1 / 3, camera->k2 = 0.02 / 7, camera->p1 = 1e-3 / 3, camera->p2 = -2e-3 / 7;
  studio.cameras[0].k3 = 0.05 / 3;
  RigEstimate rig{.model = Turntable(), .axes = {"table"}};
  rig.model.cam_from_mount = {LookingAtTheTable({0.7, 0.1, 0.2}), LookingAtTheTable({0.6, -0.3, 0.3}),
                              LookingAtTheTable({0.5, 0.2, 0.6})};
  rig.covariance.joint = Eigen::MatrixXd::Zero(RigCovariance::Size(3), RigCovariance::Size(3));
  std::vector<StopPosition> stops;
  std::vector<StopError> errors;
  std::vector<int> stop_of_view;
  constexpr int kStops = 4;
  for (int stop = 0; stop < kStops; ++stop) {
    stops.push_back({.id = std::to_string(stop), .axes = {0.3 + 1.3 * stop}});
    errors.push_back(StopError::Constant(1e-4 * stop));
    for (int c = 0; c < studio.NumCameras(); ++c) {
      studio.views.push_back({fmt::format("{}_{}.png", studio.cameras[c].id, stop), c, {}});
      stop_of_view.push_back(stop);
    }
  }
  PlaceViews(rig.model, stops, errors, stop_of_view, studio);
  studio.rig = std::move(rig);
  return studio;
}

std::map<std::string, RigCalibration> ExportExamples() {
  const RigCalibration studio = ExampleStudio();
  return {{"full", studio},
          {"no_k3", Changed(studio, [](Camera& camera) { camera.k3 = 0; })},
          {"square", Changed(studio, [](Camera& camera) { camera.fy_px = camera.fx_px; })},
          {"radial", Changed(studio, MakeRadial)},
          {"skewed", Changed(studio, [](Camera& camera) { camera = Undistorted(camera), camera.skew_px = 1.0 / 3; })},
          {"bent", Changed(studio, [](Camera& camera) { camera.skew_px = 1.0 / 3; })}};
}

}  // namespace rigcal
