#include <fmt/format.h>

#include "config/formats/number_text.h"
#include "config/formats/writers.h"

namespace rigcal {

Result<ExportedFiles> PmvsFiles(const RigCalibration& calibration) {
  ExportedFiles files;
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    // K's third row is (0, 0, 1), so the third row of P has a direction of length 1 already.
    const Eigen::Matrix<double, 3, 4> p = ProjectionMatrix(calibration.CameraOf(v), view.cam_from_world, 0);
    std::string text = "CONTOUR\n";
    for (int row = 0; row < p.rows(); ++row) text += NumbersText(RowByRow(p.row(row))) + "\n";
    files[fmt::format("txt/{:08d}.txt", v)] = text;
    files["views.txt"] += fmt::format("{:08d} {}\n", v, view.name);
  }
  return files;
}

}  // namespace rigcal
