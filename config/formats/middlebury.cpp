#include <fmt/format.h>

#include "config/formats/number_text.h"
#include "config/formats/writers.h"

namespace rigcal {

Result<ExportedFiles> MiddleburyFiles(const RigCalibration& calibration) {
  std::string text = fmt::format("{}\n", calibration.NumViews());
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    text += fmt::format("{} {} {} {}\n", view.name, NumbersText(RowByRow(calibration.CameraOf(v).CalibrationMatrix())),
                        NumbersText(RowByRow(view.cam_from_world.rotation.toRotationMatrix())),
                        NumbersText(RowByRow(view.cam_from_world.translation)));
  }
  return ExportedFiles{{"cameras_par.txt", text}};
}

}  // namespace rigcal
