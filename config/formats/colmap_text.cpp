#include <fmt/format.h>

#include "config/formats/colmap_camera.h"
#include "config/formats/colmap_rig.h"
#include "config/formats/number_text.h"
#include "config/formats/writers.h"

namespace rigcal {
namespace {

std::string RigsText(const ColmapRigs& rigs) {
  std::string text =
      "# RIG_ID NUM_SENSORS REF_SENSOR_TYPE REF_SENSOR_ID SENSORS[] as (TYPE ID HAS_POSE QW QX QY QZ TX TY TZ)\n";
  for (std::size_t r = 0; r < rigs.rigs.size(); ++r) {
    const ColmapRig& rig = rigs.rigs[r];
    text += fmt::format("{} {} CAMERA {}", r + 1, rig.cameras.size(), ColmapId(rig.cameras[0]));
    for (std::size_t i = 1; i < rig.cameras.size(); ++i)
      text += fmt::format(" CAMERA {} 1 {}", ColmapId(rig.cameras[i]), NumbersText(ColmapPose(rig.sensor_from_rig[i])));
    text += '\n';
  }
  return text;
}

std::string FramesText(const ColmapRigs& rigs, const RigCalibration& calibration) {
  std::string text =
      "# FRAME_ID RIG_ID QW QX QY QZ TX TY TZ (rig from world) NUM_DATA DATA[] as (SENSOR_TYPE SENSOR_ID DATA_ID)\n";
  for (std::size_t f = 0; f < rigs.frames.size(); ++f) {
    const ColmapFrame& frame = rigs.frames[f];
    text += fmt::format("{} {} {} {}", f + 1, ColmapId(frame.rig), NumbersText(ColmapPose(frame.rig_from_world)),
                        frame.views.size());
    for (int v : frame.views) text += fmt::format(" CAMERA {} {}", ColmapId(calibration.views[v].camera), ColmapId(v));
    text += '\n';
  }
  return text;
}

}  // namespace

Result<ExportedFiles> ColmapTextFiles(const RigCalibration& calibration) {
  std::string cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (int c = 0; c < calibration.NumCameras(); ++c) {
    const Camera& camera = calibration.cameras[c];
    const ColmapCamera colmap = ColmapCameraOf(camera);
    cameras += fmt::format("{} {} {} {} {}\n", ColmapId(c), colmap.model, camera.width_px, camera.height_px,
                           NumbersText(colmap.parameters));
  }
  std::string images = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n# POINTS2D[] as (X Y POINT3D_ID), none\n";
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    images += fmt::format("{} {} {} {}\n\n", ColmapId(v), NumbersText(ColmapPose(view.cam_from_world)),
                          ColmapId(view.camera), view.name);
  }
  ExportedFiles files = {{"cameras.txt", cameras}, {"images.txt", images}, {"points3D.txt", "# no points\n"}};
  if (const auto rigs = ColmapRigsOf(calibration)) {
    files["rigs.txt"] = RigsText(*rigs);
    files["frames.txt"] = FramesText(*rigs, calibration);
  }
  return files;
}

}  // namespace rigcal
