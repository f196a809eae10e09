#include <fmt/format.h>

#include "config/formats/conversions.h"
#include "config/formats/marks.h"
#include "config/formats/number_text.h"
#include "config/formats/quoted_text.h"
#include "config/formats/writers.h"

namespace rigcal {
namespace {

/// Where each camera stands in one common frame.
Result<std::vector<Rigid3d>> FixedPoses(const RigCalibration& calibration) {
  const int num_cameras = calibration.NumCameras();
  if (num_cameras == 1) return std::vector<Rigid3d>(1);
  std::vector<std::optional<Rigid3d>> poses(num_cameras);
  if (calibration.rig) {
    poses = calibration.rig->model.cam_from_mount;
    poses.resize(num_cameras);
  } else {
    for (const View& view : calibration.views) {
      if (poses[view.camera])
        return Fail(ErrorCode::kUnsupported,
                    "Kalibr holds cameras that are fixed to each other, and the calibration of {} cameras has no rig "
                    "that says how these are",
                    num_cameras);
      poses[view.camera] = view.cam_from_world;
    }
  }
  std::vector<Rigid3d> found;
  for (int c = 0; c < num_cameras; ++c) {
    if (!poses[c])
      return Fail(ErrorCode::kUnsupported, "camera '{}' has no place beside the others, which Kalibr needs",
                  calibration.cameras[c].id);
    found.push_back(*poses[c]);
  }
  return found;
}

std::string List(const std::vector<double>& numbers) {
  return fmt::format("[{}]", NumbersText(numbers, ", "));
}

std::string CameraText(const RigCalibration& calibration, int c) {
  const Camera& camera = calibration.cameras[c];
  std::vector<double> others;
  for (int other = 0; other < calibration.NumCameras(); ++other)
    if (other != c) others.push_back(other);
  std::string text = fmt::format("cam{}:\n  camera_model: pinhole\n", c);
  text += fmt::format("  intrinsics: {}\n", List({camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px}));
  text += camera.HasDistortion() ? fmt::format("  distortion_model: radtan\n  distortion_coeffs: {}\n",
                                               List({camera.k1, camera.k2, camera.p1, camera.p2}))
                                 : "  distortion_model: none\n  distortion_coeffs: []\n";
  text += fmt::format("  resolution: [{}, {}]\n  cam_overlaps: {}\n", camera.width_px, camera.height_px, List(others));
  return text + fmt::format("  rostopic: {}\n", Quoted("/" + camera.id));
}

}  // namespace

Result<ExportedFiles> KalibrFiles(const RigCalibration& calibration) {
  const auto poses = FixedPoses(calibration);
  if (!poses) return Fail(poses.error());
  std::string text = fmt::format("# {}\n", ExportMark("kalibr"));
  for (int c = 0; c < calibration.NumCameras(); ++c) {
    text += CameraText(calibration, c);
    if (c == 0) continue;
    const Eigen::Matrix4d cam_from_last_cam = MatrixOf((*poses)[c] * (*poses)[c - 1].Inverse());
    text += "  T_cn_cnm1:\n";
    for (int row = 0; row < cam_from_last_cam.rows(); ++row)
      text += fmt::format("  - {}\n", List(RowByRow(cam_from_last_cam.row(row))));
  }
  return ExportedFiles{{"camchain.yaml", text}};
}

}  // namespace rigcal
