#include <fmt/format.h>

#include "config/formats/conversions.h"
#include "config/formats/number_text.h"
#include "config/formats/writers.h"

namespace rigcal {

Result<ExportedFiles> BundlerFiles(const RigCalibration& calibration) {
  std::string bundle = fmt::format("# Bundle file v0.3\n{} 0\n", calibration.NumViews());
  std::string list;
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    const Camera& camera = calibration.CameraOf(v);
    const Rigid3d gl_cam_from_world = GlCamFromWorld(view.cam_from_world);
    const Eigen::Matrix3d r = gl_cam_from_world.rotation.toRotationMatrix();
    bundle += NumbersText({camera.fx_px, camera.k1, camera.k2}) + "\n";
    for (int row = 0; row < r.rows(); ++row) bundle += NumbersText(RowByRow(r.row(row))) + "\n";
    bundle += NumbersText(RowByRow(gl_cam_from_world.translation)) + "\n";
    list += view.name + "\n";
  }
  return ExportedFiles{{"bundle.out", bundle}, {"list.txt", list}};
}

}  // namespace rigcal
