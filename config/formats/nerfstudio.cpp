#include <nlohmann/json.hpp>

#include "config/formats/conversions.h"
#include "config/formats/marks.h"
#include "config/formats/writers.h"

namespace rigcal {
namespace {

/// Nested lists, row by row.
nlohmann::ordered_json Rows(const Eigen::Matrix4d& matrix) {
  nlohmann::ordered_json rows;
  for (int row = 0; row < matrix.rows(); ++row)
    rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
  return rows;
}

}  // namespace

Result<ExportedFiles> NerfstudioFiles(const RigCalibration& calibration) {
  nlohmann::ordered_json json = {{"comment", ExportMark("nerfstudio")}, {"camera_model", "OPENCV"}};
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    const Camera& camera = calibration.CameraOf(v);
    const Eigen::Vector2d centre = PrincipalPointFromCornerPx(camera);
    frames.push_back({{"file_path", view.name},
                      {"fl_x", camera.fx_px},
                      {"fl_y", camera.fy_px},
                      {"cx", centre.x()},
                      {"cy", centre.y()},
                      {"w", camera.width_px},
                      {"h", camera.height_px},
                      {"k1", camera.k1},
                      {"k2", camera.k2},
                      {"p1", camera.p1},
                      {"p2", camera.p2},
                      {"transform_matrix", Rows(MatrixOf(GlCamFromWorld(view.cam_from_world).Inverse()))}});
  }
  json["frames"] = std::move(frames);
  return ExportedFiles{{"transforms.json", json.dump(1) + "\n"}};
}

}  // namespace rigcal
