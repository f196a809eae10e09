#include "config/colmap_model.h"

#include <map>

#include "config/formats/conversions.h"
#include "config/text_fields.h"

namespace rigcal {
namespace {

/// A model's parameters in COLMAP's order; f stands for one focal length of both axes.
enum class Parameter { kF, kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2, kK3, kMustBeZero };

const std::map<std::string, std::vector<Parameter>, std::less<>>& ParametersByModel() {
  using enum Parameter;
  static const std::map<std::string, std::vector<Parameter>, std::less<>> kModels = {
      {"SIMPLE_PINHOLE", {kF, kCx, kCy}},
      {"PINHOLE", {kFx, kFy, kCx, kCy}},
      {"SIMPLE_RADIAL", {kF, kCx, kCy, kK1}},
      {"RADIAL", {kF, kCx, kCy, kK1, kK2}},
      {"OPENCV", {kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2}},
      {"FULL_OPENCV", {kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2, kK3, kMustBeZero, kMustBeZero, kMustBeZero}},
  };
  return kModels;
}

void SetParameter(Camera& camera, Parameter parameter, double value) {
  switch (parameter) {
    case Parameter::kF:
      camera.fx_px = camera.fy_px = value;
      break;
    case Parameter::kFx:
      camera.fx_px = value;
      break;
    case Parameter::kFy:
      camera.fy_px = value;
      break;
    case Parameter::kCx:
      camera.cx_px = value - kCornerOffsetPx;
      break;
    case Parameter::kCy:
      camera.cy_px = value - kCornerOffsetPx;
      break;
    case Parameter::kK1:
      camera.k1 = value;
      break;
    case Parameter::kK2:
      camera.k2 = value;
      break;
    case Parameter::kP1:
      camera.p1 = value;
      break;
    case Parameter::kP2:
      camera.p2 = value;
      break;
    case Parameter::kK3:
      camera.k3 = value;
      break;
    case Parameter::kMustBeZero:
      break;
  }
}

/// CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]
Result<Camera> ParseCamera(std::string_view text, const std::string& where) {
  constexpr std::size_t kHead = 4;
  const std::vector<std::string_view> fields = SplitFields(text);
  if (fields.size() < kHead)
    return Fail(ErrorCode::kBadInput, "{}: {} fields instead of CAMERA_ID MODEL WIDTH HEIGHT PARAMS", where,
                fields.size());
  const auto model = ParametersByModel().find(fields[1]);
  if (model == ParametersByModel().end())
    return Fail(ErrorCode::kUnsupported, "{}: the camera model {} is not supported", where, fields[1]);
  const auto width = ParseCount(fields[2], where), height = ParseCount(fields[3], where);
  if (!width) return Fail(width.error());
  if (!height) return Fail(height.error());
  if (*width == 0 || *height == 0)
    return Fail(ErrorCode::kBadInput, "{}: the image size {} x {} px is empty", where, *width, *height);
  const auto numbers = ParseNumbers(std::span(fields).subspan(kHead), where);
  if (!numbers) return Fail(numbers.error());
  if (numbers->size() != model->second.size())
    return Fail(ErrorCode::kBadInput, "{}: {} parameters, the model {} has {}", where, numbers->size(), fields[1],
                model->second.size());
  Camera camera;
  camera.id = camera.physical_id = std::string(fields[0]);
  camera.width_px = *width, camera.height_px = *height;
  for (std::size_t i = 0; i < numbers->size(); ++i) {
    if (model->second[i] == Parameter::kMustBeZero && (*numbers)[i] != 0)
      return Fail(ErrorCode::kUnsupported, "{}: k4, k5 and k6 of FULL_OPENCV must be 0, one is {}", where,
                  (*numbers)[i]);
    SetParameter(camera, model->second[i], (*numbers)[i]);
  }
  return camera;
}

Result<std::map<std::string, Camera, std::less<>>> ParseCameras(std::string_view text, const std::string& file) {
  std::map<std::string, Camera, std::less<>> camera_by_id;
  for (const TextLine& line : SplitLines(text)) {
    const std::string_view content = Trimmed(line.text);
    if (content.empty() || content.starts_with('#')) continue;
    const std::string where = fmt::format("{} line {}", file, line.number);
    Result<Camera> camera = ParseCamera(content, where);
    if (!camera) return Fail(camera.error());
    const std::string id = camera->id;
    if (!camera_by_id.emplace(id, *std::move(camera)).second)
      return Fail(ErrorCode::kBadInput, "{}: the camera {} is there twice", where, id);
  }
  return camera_by_id;
}

/// IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME; the name may hold spaces.
Result<CameraRecord> ParseImage(std::string_view text, const std::string& where,
                                const std::map<std::string, Camera, std::less<>>& camera_by_id) {
  constexpr std::size_t kFields = 10, kPose = 1, kPoseNumbers = 7, kCamera = 8, kName = 9;
  const std::vector<std::string_view> fields = SplitFields(text);
  if (fields.size() < kFields)
    return Fail(ErrorCode::kBadInput, "{}: {} fields instead of IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", where,
                fields.size());
  CameraRecord record;
  record.name = std::string(Trimmed(text.substr(static_cast<std::size_t>(fields[kName].data() - text.data()))));
  record.where = fmt::format("{} ({})", where, record.name);
  const auto pose = ParseNumbers(std::span(fields).subspan(kPose, kPoseNumbers), record.where);
  if (!pose) return Fail(pose.error());
  const double* n = pose->data();
  const auto rotation = RotationFromQuaternion(n[0], n[1], n[2], n[3], record.where);
  if (!rotation) return Fail(rotation.error());
  record.cam_from_world = {*rotation, Eigen::Vector3d(n[4], n[5], n[6])};
  const auto camera = camera_by_id.find(fields[kCamera]);
  if (camera == camera_by_id.end())
    return Fail(ErrorCode::kBadInput, "{}: the camera {} is not in cameras.txt", record.where, fields[kCamera]);
  record.camera = camera->second;
  return record;
}

}  // namespace

Result<std::vector<CameraRecord>> ParseColmapModel(std::string_view cameras_text, std::string_view images_text,
                                                   const std::string& folder) {
  const auto camera_by_id = ParseCameras(cameras_text, folder + "/cameras.txt");
  if (!camera_by_id) return Fail(camera_by_id.error());
  std::vector<CameraRecord> records;
  bool is_points_line = false;  // every image line is followed by a line of points, which may be empty
  for (const TextLine& line : SplitLines(images_text)) {
    const std::string where = fmt::format("{}/images.txt line {}", folder, line.number);
    const std::string_view content = Trimmed(line.text);
    if (is_points_line) {
      is_points_line = false;
      const auto fields = SplitFields(content);
      if (fields.size() % 3 != 0 || !ParseNumbers(fields, where))
        return Fail(ErrorCode::kBadInput,
                    "{}: a line of points (X Y POINT3D_ID ..., may be empty) must follow each image", where);
      continue;
    }
    if (content.empty() || content.starts_with('#')) continue;
    Result<CameraRecord> record = ParseImage(content, where, *camera_by_id);
    if (!record) return Fail(record.error());
    records.push_back(*std::move(record));
    is_points_line = true;
  }
  return records;
}

}  // namespace rigcal
