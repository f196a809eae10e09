#include "config/recording_pictures.h"

#include <set>

#include "config/decode_image.h"
#include "config/recording_file.h"

namespace rigcal {

Result<RecordedFile> LoadRecordedFile(const std::filesystem::path& folder, const Recording& recording, int view) {
  const RecordedView& recorded = recording.views.at(view);
  const std::string path = (folder / recorded.file).string();
  Result<std::string> bytes = ReadFile(path);
  if (!bytes) return Fail(bytes.error());
  if (Result<void> same = CheckSha256(Sha256Hex(*bytes), recorded.sha256, path); !same) return Fail(same.error());
  Result<cv::Mat> picture = DecodeImage(*bytes, path);
  if (!picture) return Fail(picture.error());
  const RecordedCamera& camera = recording.cameras.at(recorded.camera);
  if (picture->cols != camera.width_px || picture->rows != camera.height_px)
    return Fail(ErrorCode::kBadInput, "{}: the image is {} x {} px, its camera '{}' is {} x {} px", path, picture->cols,
                picture->rows, camera.id, camera.width_px, camera.height_px);
  return RecordedFile{std::move(*bytes), std::move(*picture)};
}

Result<cv::Mat> LoadRecordedPicture(const std::filesystem::path& folder, const Recording& recording, int view) {
  Result<RecordedFile> file = LoadRecordedFile(folder, recording, view);
  if (!file) return Fail(file.error());
  return std::move(file->pixels);
}

Result<RecordedObject> LoadRecordedObject(const std::filesystem::path& folder) {
  const std::string file = (folder / kRecordingFile).string();
  const Result<std::string> text = ReadFile(file);
  if (!text) return Fail(text.error());
  Result<Recording> recording = ParseRecording(*text, file);
  if (!recording) return Fail(recording.error());
  if (!recording->closed)
    return Fail(ErrorCode::kBadInput, "{}: the recording is not closed: it was interrupted after {} views", file,
                recording->views.size());
  if (recording->views.empty()) return Fail(ErrorCode::kBadInput, "{}: the recording is empty, it has no view", file);
  RecordedObject object;
  for (const RecordedView& view : recording->views) {
    if (view.subject == Subject::kChart) continue;
    object.camera_by_image[view.file] = recording->cameras[view.camera].id;
    object.sha256_by_image[view.file] = view.sha256;
  }
  if (object.camera_by_image.empty())
    return Fail(ErrorCode::kBadInput, "{}: none of its {} views shows an object", file, recording->views.size());
  object.file = {kRecordingFile, Sha256Hex(*text)};
  object.recording = std::move(*recording);
  return object;
}

Result<void> CheckAllHaveCameras(const RecordedObject& object, const RigCalibration& calibration,
                                 const std::string& cameras) {
  std::set<std::string> with_camera;
  for (const View& view : calibration.views) with_camera.insert(view.name);
  for (const auto& [image, camera] : object.camera_by_image) {
    if (!with_camera.contains(image))
      return Fail(ErrorCode::kBadInput, "{}: has no camera for the picture '{}' of the recording", cameras, image);
  }
  return {};
}

}  // namespace rigcal
