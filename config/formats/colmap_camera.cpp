#include "config/formats/colmap_camera.h"

#include "config/formats/conversions.h"

namespace rigcal {
namespace {

constexpr int kPinholeId = 1, kOpenCvId = 4, kFullOpenCvId = 6;  // src/colmap/sensor/models.h

}  // namespace

ColmapCamera ColmapCameraOf(const Camera& camera) {
  const Eigen::Vector2d centre = PrincipalPointFromCornerPx(camera);
  ColmapCamera colmap{"PINHOLE", kPinholeId, {camera.fx_px, camera.fy_px, centre.x(), centre.y()}};
  std::vector<double>& parameters = colmap.parameters;
  if (!camera.HasDistortion()) return colmap;
  colmap.model = "OPENCV", colmap.model_id = kOpenCvId;
  parameters.insert(parameters.end(), {camera.k1, camera.k2, camera.p1, camera.p2});
  if (camera.k3 == 0) return colmap;
  colmap.model = "FULL_OPENCV", colmap.model_id = kFullOpenCvId;
  parameters.insert(parameters.end(), {camera.k3, 0, 0, 0});
  return colmap;
}

std::vector<double> ColmapPose(const Rigid3d& b_from_a) {
  const Eigen::Quaterniond& q = b_from_a.rotation;
  const Eigen::Vector3d& t = b_from_a.translation;
  return {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
}

}  // namespace rigcal
