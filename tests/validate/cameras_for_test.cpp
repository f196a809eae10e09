#include "tests/validate/cameras_for_test.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>

namespace rigcal::test {

Rigid3d LookingAt(const Eigen::Vector3d& centre_in_world, const Eigen::Vector3d& target_in_world) {
  const Eigen::Vector3d z = (target_in_world - centre_in_world).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d cam_from_world;
  cam_from_world << x.transpose(), z.cross(x).transpose(), z.transpose();
  Rigid3d pose;
  pose.rotation = Eigen::Quaterniond(cam_from_world).normalized();
  pose.translation = -(pose.rotation * centre_in_world);
  return pose;
}

RigCalibration InFrame(const RigCalibration& calibration, double scale, const Eigen::Quaterniond& rotation,
                       const Eigen::Vector3d& translation) {
  RigCalibration moved = calibration;
  for (View& view : moved.views) {
    view.cam_from_world.rotation = (view.cam_from_world.rotation * rotation.conjugate()).normalized();
    view.cam_from_world.translation =
        scale * view.cam_from_world.translation - view.cam_from_world.rotation * translation;
  }
  return moved;
}

RigCalibration SixCameras() {
  RigCalibration six;
  six.cameras.push_back({.id = "cam0",
                         .physical_id = "cam0",
                         .width_px = 640,
                         .height_px = 480,
                         .fx_px = 1000,
                         .fy_px = 1000,
                         .cx_px = 320,
                         .cy_px = 240});
  for (int i = 0; i < 6; ++i) {
    const double angle_rad = i * std::numbers::pi / 4;
    const Eigen::Vector3d centre(2 * std::cos(angle_rad), 2 * std::sin(angle_rad), 0.5 + 0.1 * i);
    six.views.push_back({fmt::format("v{}", i), 0, LookingAt(centre, Eigen::Vector3d::Zero())});
  }
  return six;
}

std::vector<ComparePoint> LatticePoints() {
  std::vector<ComparePoint> points;
  for (int k = 0; k < 64; ++k) {
    points.push_back({Eigen::Vector3d(-0.3 + 0.2 * (k / 16), -0.3 + 0.2 * (k / 4 % 4), -0.3 + 0.2 * (k % 4)), {}});
  }
  return points;
}

RigCalibration DisturbedBySines(const RigCalibration& calibration, double amplitude) {
  RigCalibration disturbed = calibration;
  disturbed.cameras.clear();
  for (int i = 0; i < calibration.NumViews(); ++i) {
    double noise[10];
    for (int k = 0; k < 10; ++k) noise[k] = amplitude * std::sin(12.9898 * (10 * i + k + 1));
    Camera camera = calibration.CameraOf(i);
    camera.fx_px *= 1 + 0.01 * noise[0];
    camera.fy_px *= 1 + 0.01 * noise[1];
    camera.cx_px += 5 * noise[2];
    camera.cy_px += 5 * noise[3];
    disturbed.cameras.push_back(camera);
    View& view = disturbed.views[i];
    view.camera = i;
    Eigen::Matrix<double, 6, 1> delta;
    const double length = view.cam_from_world.translation.norm();
    for (int k = 0; k < 6; ++k) delta[k] = (k < 3 ? 0.004 : 0.005 * length) * noise[4 + k];
    view.cam_from_world = Disturbed(view.cam_from_world, delta);
  }
  return InFrame(disturbed, 2.5, ExpRotation(Eigen::Vector3d(0.3, -0.5, 0.9)), Eigen::Vector3d(0.4, -1.0, 3.0));
}

std::optional<RecordedCameras> ReadRecordedCameras(const std::string& folder, const std::string& par_name, int width_px,
                                                   int height_px) {
  const char* root = std::getenv("RIGCAL_DATA");
  if (root == nullptr) return std::nullopt;
  const std::string path = std::string(root) + "/" + folder + "/";
  std::ifstream par(path + par_name), xyz(path + "ref_points.txt");
  if (!par || !xyz) return std::nullopt;
  RecordedCameras read;
  int count = 0;
  par >> count;
  for (int i = 0; i < count; ++i) {
    std::string name;
    double k[9], r[9], t[3];
    par >> name;
    for (double& v : k) par >> v;
    for (double& v : r) par >> v;
    for (double& v : t) par >> v;
    if (i == 0) {
      read.calibration.cameras.push_back({.id = "cam0",
                                          .physical_id = "cam0",
                                          .width_px = width_px,
                                          .height_px = height_px,
                                          .fx_px = k[0],
                                          .fy_px = k[4],
                                          .cx_px = k[2],
                                          .cy_px = k[5]});
    }
    View view{name, 0, {}};
    const Eigen::Matrix3d rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r);
    view.cam_from_world = {Eigen::Quaterniond(rotation).normalized(), Eigen::Vector3d(t[0], t[1], t[2])};
    read.calibration.views.push_back(view);
  }
  for (std::string line; std::getline(xyz, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    ComparePoint point;
    std::size_t num_views = 0;
    fields >> point.x_in_world.x() >> point.x_in_world.y() >> point.x_in_world.z() >> num_views;
    point.views.resize(num_views);
    for (int& v : point.views) fields >> v;
    read.points.push_back(point);
  }
  return read;
}

}  // namespace rigcal::test
