#include <fmt/format.h>

#include "config/formats/number_text.h"
#include "config/formats/view_file_names.h"
#include "config/formats/writers.h"

namespace rigcal {
namespace {

std::string ModelText(const Camera& camera, const Rigid3d& cam_from_world) {
  std::vector<double> intrinsics = {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
  if (camera.HasDistortion())
    intrinsics.insert(intrinsics.end(), {camera.k1, camera.k2, camera.p1, camera.p2, camera.k3});
  const Eigen::Vector3d r = LogRotation(cam_from_world.rotation);
  const Eigen::Vector3d& t = cam_from_world.translation;
  return fmt::format(
      "{{\n    'lensmodel':  '{}',\n    'intrinsics': [ {},],\n    'extrinsics': [ {},],\n"
      "    'imagersize': [ {}, {},],\n}}\n",
      camera.HasDistortion() ? "LENSMODEL_OPENCV5" : "LENSMODEL_PINHOLE", NumbersText(intrinsics, ", "),
      NumbersText({r.x(), r.y(), r.z(), t.x(), t.y(), t.z()}, ", "), camera.width_px, camera.height_px);
}

}  // namespace

Result<ExportedFiles> MrcalFiles(const RigCalibration& calibration) {
  const auto names = ViewFileNames(calibration, ".cameramodel");
  if (!names) return Fail(names.error());
  ExportedFiles files;
  for (int v = 0; v < calibration.NumViews(); ++v)
    files[(*names)[v]] = ModelText(calibration.CameraOf(v), calibration.views[v].cam_from_world);
  return files;
}

}  // namespace rigcal
