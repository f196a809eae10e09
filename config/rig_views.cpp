#include "config/rig_views.h"

#include <algorithm>

#include "config/calibration_file.h"
#include "config/camera_records.h"
#include "config/load_cameras.h"
#include "config/rig_file.h"
#include "core/rig/rig_model_pose.h"

namespace rigcal {
namespace {

/// Which camera of the calibration a camera of the recording is.
Result<int> CameraIn(const RigCalibration& rigged, const std::string& cameras, const RecordedCamera& recorded,
                     const std::string& recording_name) {
  const auto found = std::ranges::find(rigged.cameras, recorded.id, &Camera::id);
  if (found == rigged.cameras.end())
    return Fail(ErrorCode::kBadInput, "{}: has no camera '{}', which {} was taken with", cameras, recorded.id,
                recording_name);
  if (found->width_px != recorded.width_px || found->height_px != recorded.height_px)
    return Fail(ErrorCode::kBadInput, "{}: the camera '{}' is {} x {} px, in {} it is {} x {} px", cameras, recorded.id,
                found->width_px, found->height_px, recording_name, recorded.width_px, recorded.height_px);
  const std::string where = fmt::format("{}: camera '{}'", cameras, recorded.id);
  if (const Result<void> checked = CheckIntrinsics(*found, where, false); !checked) return Fail(checked.error());
  const int camera = static_cast<int>(found - rigged.cameras.begin());
  if (!rigged.rig->model.cam_from_mount[camera])
    return Fail(ErrorCode::kBadInput,
                "{}: the camera '{}' has no place in the rig, it never saw the chart at a stop; calibrate it again",
                cameras, recorded.id);
  return camera;
}

}  // namespace

Result<std::optional<RiggedCameras>> LoadRiggedCameras(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return std::nullopt;
  const Result<std::string> text = ReadFile(path);
  if (!text) return Fail(text.error());
  const std::size_t begin = text->find_first_not_of(" \t\r\n");
  if (begin == std::string::npos || (*text)[begin] != '{') return std::nullopt;
  Result<CalibrationContent> content = ParseCalibration(*text, path.string());
  if (!content) return Fail(content.error());
  if (!content->calibration.rig) return std::nullopt;
  return RiggedCameras{std::move(content->calibration), {path.filename().string(), Sha256Hex(*text)}};
}

Result<RigViews> PlaceRecording(const RigCalibration& rigged, const std::string& cameras, const Recording& recording,
                                const std::string& recording_name) {
  RigViews placed{.calibration = rigged};
  placed.calibration.views.clear();
  placed.calibration.covariance.reset();
  Result<std::vector<StopPosition>> stops =
      StopPositions(recording, {rigged.rig->model, rigged.rig->axes}, recording_name);
  if (!stops) return Fail(stops.error());
  placed.stops = std::move(*stops);
  for (const RecordedView& view : recording.views) {
    if (view.subject == Subject::kChart) continue;
    const Result<int> camera = CameraIn(rigged, cameras, recording.cameras[view.camera], recording_name);
    if (!camera) return Fail(camera.error());
    if (!view.stop)
      return Fail(ErrorCode::kBadInput, "{}: the picture '{}' has no stop, so the rig gives it no pose", recording_name,
                  view.file);
    placed.calibration.views.push_back({view.file, *camera, {}});
    placed.stop_of_view.push_back(*view.stop);
  }
  const int least = CameraFileOptions{}.min_views;
  if (placed.calibration.NumViews() < least)
    return Fail(ErrorCode::kBadInput, "{}: shows the object in {} views, at least {} are needed", recording_name,
                placed.calibration.NumViews(), least);
  const std::vector<StopError> exact(placed.stops.size(), StopError::Zero());
  PlaceViews(rigged.rig->model, placed.stops, exact, placed.stop_of_view, placed.calibration);
  return placed;
}

}  // namespace rigcal
