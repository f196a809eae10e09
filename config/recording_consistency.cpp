#include <cmath>
#include <filesystem>
#include <regex>
#include <set>
#include <tuple>

#include "config/json_text.h"
#include "config/name_pattern.h"
#include "config/recording_file.h"

namespace rigcal {
namespace {

constexpr std::size_t kMaxIdLength = 256;  ///< characters of an id or a serial number

Result<void> CheckText(const std::string& what, const std::string& text, std::size_t max_length) {
  if (text.empty() || text.size() > max_length)
    return Fail(ErrorCode::kBadInput, "{} has {} characters, 1 to {} are allowed", what, text.size(), max_length);
  if (!IsUtf8(text)) return Fail(ErrorCode::kBadInput, "{} is not text in UTF-8", what);
  return {};
}

Result<void> CheckFinite(const std::string& what, const std::optional<double>& value) {
  if (value && !std::isfinite(*value)) return Fail(ErrorCode::kBadInput, "{} is {}, not a finite number", what, *value);
  return {};
}

Result<void> CheckAbove0(const std::string& what, const std::optional<double>& value) {
  if (value && !(std::isfinite(*value) && *value > 0))
    return Fail(ErrorCode::kBadInput, "{} is {}, a finite number above 0 is needed", what, *value);
  return {};
}

Result<void> CheckCamera(const RecordedCamera& camera) {
  if (Result<void> ok = CheckText("a camera's id", camera.id, kMaxIdLength); !ok) return ok;
  const std::string where = fmt::format("camera '{}'", camera.id);
  if (camera.width_px < 1 || camera.height_px < 1)
    return Fail(ErrorCode::kBadInput, "{}: its size is {} x {} px, at least 1 x 1 is needed", where, camera.width_px,
                camera.height_px);
  for (const std::string* text : {&camera.serial, &camera.model, &camera.lens, &camera.pixel_format}) {
    if (text->empty()) continue;
    if (Result<void> ok = CheckText(where + ": its description", *text, kMaxIdLength); !ok) return ok;
  }
  if (Result<void> ok = CheckAbove0(where + ": focus_m", camera.focus_m); !ok) return ok;
  return CheckFinite(where + ": temperature_celsius", camera.temperature_celsius);
}

Result<void> CheckStop(const RecordedStop& stop) {
  if (Result<void> ok = CheckText("a stop's id", stop.id, kMaxIdLength); !ok) return ok;
  const std::string where = fmt::format("stop '{}'", stop.id);
  std::set<std::string> axes;
  for (const AxisPosition& position : stop.axes) {
    if (Result<void> ok = CheckText(where + ": an axis' name", position.axis, kMaxIdLength); !ok) return ok;
    const std::string axis = fmt::format("{}: axis '{}'", where, position.axis);
    if (!axes.insert(position.axis).second) return Fail(ErrorCode::kBadInput, "{} is there twice", axis);
    for (const std::optional<double>& value : {std::optional(position.commanded), position.reported})
      if (Result<void> ok = CheckFinite(axis, value); !ok) return ok;
  }
  for (const auto& pose : {stop.base_from_flange_commanded, stop.base_from_flange_reported}) {
    if (pose && !(pose->translation.allFinite() && pose->rotation.coeffs().allFinite()))
      return Fail(ErrorCode::kBadInput, "{}: its pose holds a number that is not finite", where);
  }
  return {};
}

/// Inside the folder, and written in one way only.
Result<void> CheckFileName(const std::string& file) {
  if (Result<void> ok = CheckText("a view's file name", file, kMaxImageNameLength); !ok) return ok;
  const std::filesystem::path path(file);
  const bool inside = path.is_relative() && path.lexically_normal().string() == file && path.has_filename() &&
                      *path.begin() != ".." && *path.begin() != "." && file.find('\0') == std::string::npos;
  if (!inside) return Fail(ErrorCode::kBadInput, "view '{}': is not a file name inside the recording's folder", file);
  if (file == kRecordingFile)
    return Fail(ErrorCode::kBadInput, "view '{}': has the name of the recording's list", file);
  return {};
}

Result<void> CheckView(const RecordedView& view, const Recording& recording) {
  if (Result<void> ok = CheckFileName(view.file); !ok) return ok;
  const std::string where = fmt::format("view '{}'", view.file);
  if (view.camera < 0 || view.camera >= static_cast<int>(recording.cameras.size()))
    return Fail(ErrorCode::kBadInput, "{}: its camera has number {}, there are {}", where, view.camera,
                recording.cameras.size());
  if (view.stop && (*view.stop < 0 || *view.stop >= static_cast<int>(recording.stops.size())))
    return Fail(ErrorCode::kBadInput, "{}: its stop has number {}, there are {}", where, *view.stop,
                recording.stops.size());
  if (view.sha256.size() != 64 || view.sha256.find_first_not_of("0123456789abcdef") != std::string::npos)
    return Fail(ErrorCode::kBadInput, "{}: its sha256 is '{}', 64 hexadecimal digits are needed", where, view.sha256);
  if (Result<void> ok = CheckAbove0(where + ": exposure_us", view.exposure_us); !ok) return ok;
  if (Result<void> ok = CheckFinite(where + ": gain_db", view.gain_db); !ok) return ok;
  static const std::regex kUtc(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,9})?Z)");
  if (view.taken_at && (view.taken_at->size() > kMaxIdLength || !std::regex_match(*view.taken_at, kUtc)))
    return Fail(ErrorCode::kBadInput, "{}: taken_at is '{}', a time like 2025-01-31T12:00:00Z is needed", where,
                *view.taken_at);
  return {};
}

Result<void> CheckCameras(const Recording& recording) {
  std::set<std::string> ids, serials;
  for (const RecordedCamera& camera : recording.cameras) {
    if (Result<void> ok = CheckCamera(camera); !ok) return ok;
    if (!ids.insert(camera.id).second) return Fail(ErrorCode::kBadInput, "the camera '{}' is there twice", camera.id);
    if (!camera.serial.empty() && !serials.insert(camera.serial).second)
      return Fail(ErrorCode::kBadInput, "camera '{}': another one has the serial number '{}' too", camera.id,
                  camera.serial);
  }
  return {};
}

Result<void> CheckViews(const Recording& recording) {
  std::set<std::string> files;
  std::set<std::tuple<int, int, Subject>> taken;
  for (const RecordedView& view : recording.views) {
    if (Result<void> ok = CheckView(view, recording); !ok) return ok;
    if (!files.insert(view.file).second) return Fail(ErrorCode::kBadInput, "the view '{}' is there twice", view.file);
    if (view.stop && !taken.emplace(view.camera, *view.stop, view.subject).second)
      return Fail(ErrorCode::kBadInput, "view '{}': camera '{}' has another picture ({}) at stop '{}'", view.file,
                  recording.cameras[view.camera].id, NameOf(view.subject), recording.stops[*view.stop].id);
  }
  return {};
}

}  // namespace

Result<void> CheckConsistent(const Recording& recording) {
  if (Result<void> ok = CheckText("the recording's id", recording.id, kMaxIdLength); !ok) return ok;
  if (Result<void> ok = CheckCameras(recording); !ok) return ok;
  std::set<std::string> stops;
  for (const RecordedStop& stop : recording.stops) {
    if (Result<void> ok = CheckStop(stop); !ok) return ok;
    if (!stops.insert(stop.id).second) return Fail(ErrorCode::kBadInput, "the stop '{}' is there twice", stop.id);
  }
  return CheckViews(recording);
}

}  // namespace rigcal
