#include "config/export_text.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <vector>

#include "config/colmap_model.h"

namespace rigcal {
namespace {

/// " 1.5 2 3" with 17 significant digits.
std::string Numbers(const std::vector<double>& numbers) {
  std::string text;
  for (double number : numbers) text += fmt::format(" {:.17g}", number);
  return text;
}

std::string ColmapCamera(const Camera& camera) {
  std::vector<double> parameters = {camera.fx_px, camera.fy_px, camera.cx_px + kColmapPixelOffset,
                                    camera.cy_px + kColmapPixelOffset};
  const char* model = "PINHOLE";
  if (camera.HasDistortion()) {
    model = "OPENCV";
    parameters.insert(parameters.end(), {camera.k1, camera.k2, camera.p1, camera.p2});
  }
  if (camera.k3 != 0) {
    model = "FULL_OPENCV";
    parameters.insert(parameters.end(), {camera.k3, 0, 0, 0});
  }
  return fmt::format("{} {} {}{}\n", model, camera.width_px, camera.height_px, Numbers(parameters));
}

template <int kRows, int kColumns>
cv::Mat1d ToMat(const Eigen::Matrix<double, kRows, kColumns>& matrix) {
  cv::Mat1d mat(kRows, kColumns);
  for (int row = 0; row < mat.rows; ++row)
    for (int column = 0; column < mat.cols; ++column) mat(row, column) = matrix(row, column);
  return mat;
}

void WriteCamera(const Camera& camera, cv::FileStorage& file) {
  file << "{"
       << "id" << camera.id;
  if (camera.width_px > 0 && camera.height_px > 0)
    file << "image_width" << camera.width_px << "image_height" << camera.height_px;
  file << "camera_matrix" << ToMat(camera.CalibrationMatrix());
  file << "distortion_coefficients" << (cv::Mat1d(1, 5) << camera.k1, camera.k2, camera.p1, camera.p2, camera.k3);
  file << "}";
}

void WriteView(const RigCalibration& calibration, int v, cv::FileStorage& file) {
  const View& view = calibration.views[v];
  file << "{"
       << "name" << view.name << "camera" << view.camera;
  file << "rvec" << ToMat(LogRotation(view.cam_from_world.rotation));
  file << "tvec" << ToMat(view.cam_from_world.translation);
  file << "}";
}

}  // namespace

ExportedFiles ColmapFiles(const RigCalibration& calibration) {
  std::string cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (int c = 0; c < calibration.NumCameras(); ++c)
    cameras += fmt::format("{} {}", c + 1, ColmapCamera(calibration.cameras[c]));
  std::string images = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n# POINTS2D[] as (X Y POINT3D_ID), none\n";
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    const Eigen::Quaterniond& q = view.cam_from_world.rotation;
    const Eigen::Vector3d& t = view.cam_from_world.translation;
    images += fmt::format("{}{} {} {}\n\n", v + 1, Numbers({q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}),
                          view.camera + 1, view.name);
  }
  return {{"cameras.txt", cameras}, {"images.txt", images}, {"points3D.txt", "# no points\n"}};
}

ExportedFiles PmvsFiles(const RigCalibration& calibration) {
  ExportedFiles files;
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    // K's third row is (0, 0, 1), so the third row of P has a direction of length 1 already.
    const Eigen::Matrix<double, 3, 4> p = ProjectionMatrix(calibration.CameraOf(v), view.cam_from_world, 0);
    std::string text = "CONTOUR\n";
    for (int row = 0; row < 3; ++row) text += Numbers({p(row, 0), p(row, 1), p(row, 2), p(row, 3)}).substr(1) + "\n";
    files[fmt::format("txt/{:08d}.txt", v)] = text;
    files["views.txt"] += fmt::format("{:08d} {}\n", v, view.name);
  }
  return files;
}

std::string OpenCvText(const RigCalibration& calibration) {
  cv::FileStorage file(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
  file.writeComment("x_in_cam = R(rvec) x_in_world + tvec; pixel (0,0) is the centre of the top-left pixel");
  file << "unit" << (calibration.unit == LengthUnit::kMetre ? "m" : "unknown");
  file << "cameras"
       << "[";
  for (const Camera& camera : calibration.cameras) WriteCamera(camera, file);
  file << "]"
       << "views"
       << "[";
  for (int v = 0; v < calibration.NumViews(); ++v) WriteView(calibration, v, file);
  file << "]";
  return file.releaseAndGetString();
}

}  // namespace rigcal
