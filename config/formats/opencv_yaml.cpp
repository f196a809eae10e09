#include "config/formats/opencv_yaml.h"

#include "config/formats/marks.h"
#include "config/formats/writers.h"

namespace rigcal {
namespace {

void WriteCamera(const Camera& camera, cv::FileStorage& file) {
  file << "{"
       << "id" << camera.id;
  if (camera.width_px > 0 && camera.height_px > 0)
    file << "image_width" << camera.width_px << "image_height" << camera.height_px;
  file << "camera_matrix" << ToMat(camera.CalibrationMatrix());
  file << "distortion_coefficients" << DistortionCoefficients(camera);
  file << "}";
}

void WriteView(const View& view, cv::FileStorage& file) {
  file << "{"
       << "name" << view.name << "camera" << view.camera;
  file << "rvec" << ToMat(LogRotation(view.cam_from_world.rotation));
  file << "tvec" << ToMat(view.cam_from_world.translation);
  file << "}";
}

}  // namespace

cv::Mat1d DistortionCoefficients(const Camera& camera) {
  return (cv::Mat1d(1, 5) << camera.k1, camera.k2, camera.p1, camera.p2, camera.k3);
}

cv::FileStorage YamlInMemory(const std::string& comment) {
  cv::FileStorage file(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
  file.writeComment(comment);
  return file;
}

Result<ExportedFiles> OpenCvFiles(const RigCalibration& calibration) {
  cv::FileStorage file = YamlInMemory(ExportMark("opencv"));
  file.writeComment("x_in_cam = R(rvec) x_in_world + tvec; pixel (0,0) is the centre of the top-left pixel");
  file << "unit" << (calibration.unit == LengthUnit::kMetre ? "m" : "unknown");
  file << "cameras"
       << "[";
  for (const Camera& camera : calibration.cameras) WriteCamera(camera, file);
  file << "]"
       << "views"
       << "[";
  for (const View& view : calibration.views) WriteView(view, file);
  file << "]";
  return ExportedFiles{{"cameras.yml", file.releaseAndGetString()}};
}

std::string UndistortionText(const RigCalibration& photographs, const RigCalibration& undistorted) {
  cv::FileStorage file = YamlInMemory(
      "undistorted = cv::undistort(photograph, camera_matrix, distortion_coefficients, "
      "new_camera_matrix)");
  file << "cameras"
       << "[";
  for (int c = 0; c < photographs.NumCameras(); ++c) {
    file << "{"
         << "id" << photographs.cameras[c].id;
    file << "camera_matrix" << ToMat(photographs.cameras[c].CalibrationMatrix());
    file << "distortion_coefficients" << DistortionCoefficients(photographs.cameras[c]);
    file << "new_camera_matrix" << ToMat(undistorted.cameras[c].CalibrationMatrix());
    file << "}";
  }
  file << "]";
  return file.releaseAndGetString();
}

}  // namespace rigcal
