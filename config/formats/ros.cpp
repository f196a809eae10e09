#include <fmt/format.h>

#include "config/formats/number_text.h"
#include "config/formats/quoted_text.h"
#include "config/formats/writers.h"

namespace rigcal {
namespace {

std::string MatrixText(const char* key, const Eigen::MatrixXd& matrix) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n", key, matrix.rows(), matrix.cols(),
                     NumbersText(RowByRow(matrix), ", "));
}

std::string CameraText(const Camera& camera) {
  Eigen::Matrix<double, 1, 5> plumb_bob;
  plumb_bob << camera.k1, camera.k2, camera.p1, camera.p2, camera.k3;
  Eigen::Matrix<double, 3, 4> projection = Eigen::Matrix<double, 3, 4>::Zero();  // of the undistorted picture
  projection.leftCols<3>() = camera.CalibrationMatrix();
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", camera.width_px, camera.height_px,
                     Quoted(camera.id)) +
         MatrixText("camera_matrix", camera.CalibrationMatrix()) + "distortion_model: plumb_bob\n" +
         MatrixText("distortion_coefficients", plumb_bob) +
         MatrixText("rectification_matrix", Eigen::Matrix3d::Identity()) + MatrixText("projection_matrix", projection);
}

}  // namespace

Result<ExportedFiles> RosFiles(const RigCalibration& calibration) {
  ExportedFiles files;
  for (const Camera& camera : calibration.cameras) files[camera.id + ".yaml"] = CameraText(camera);
  return files;
}

}  // namespace rigcal
