#include "config/recording_file.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <limits>
#include <map>

#include "config/json_content.h"
#include "config/json_text.h"
#include "config/read_file.h"
#include "core/base/ensure.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr DocumentFormat kFormat = {"rigcal recording", 1};
constexpr std::array<std::pair<const char*, Subject>, 3> kSubjects = {
    {{"chart", Subject::kChart}, {"object", Subject::kObject}, {"both", Subject::kBoth}}};
constexpr const char* kTranslation = "translation_m";

const char* Suffix(AxisUnit unit) {
  return unit == AxisUnit::kRadian ? "_rad" : "_m";
}

void PutText(Json& json, const char* key, const std::string& text) {
  if (!text.empty()) json[key] = text;
}

template <typename Value>
void Put(Json& json, const char* key, const std::optional<Value>& value) {
  if (value) json[key] = *value;
}

Json CameraJson(const RecordedCamera& camera) {
  Json json = {{"id", camera.id}, {"width_px", camera.width_px}, {"height_px", camera.height_px}};
  PutText(json, "serial", camera.serial);
  PutText(json, "model", camera.model);
  PutText(json, "lens", camera.lens);
  PutText(json, "pixel_format", camera.pixel_format);
  Put(json, "focus_m", camera.focus_m);
  Put(json, "temperature_celsius", camera.temperature_celsius);
  return json;
}

Json StopJson(const RecordedStop& stop) {
  Json json = {{"id", stop.id}};
  for (const AxisPosition& position : stop.axes) {
    const std::string suffix = Suffix(position.unit);
    Json axis = {{"axis", position.axis}, {"commanded" + suffix, position.commanded}};
    if (position.reported) axis["reported" + suffix] = *position.reported;
    json["axes"].push_back(std::move(axis));
  }
  if (stop.base_from_flange_commanded)
    json["base_from_flange_commanded"] = PoseJson(*stop.base_from_flange_commanded, kTranslation);
  if (stop.base_from_flange_reported)
    json["base_from_flange_reported"] = PoseJson(*stop.base_from_flange_reported, kTranslation);
  return json;
}

Json ViewJson(const RecordedView& view, const Recording& recording) {
  Json json = {{"file", view.file}, {"camera", recording.cameras.at(view.camera).id}};
  if (view.stop) json["stop"] = recording.stops.at(*view.stop).id;
  json["subject"] = NameOf(view.subject);
  json["sha256"] = view.sha256;
  Put(json, "exposure_us", view.exposure_us);
  Put(json, "gain_db", view.gain_db);
  Put(json, "taken_at", view.taken_at);
  return json;
}

/// Throws BadContent when an object has another key than these, which the library would pass over.
void RefuseOtherKeys(const Json& json, const std::string& where, std::initializer_list<std::string_view> keys) {
  if (!json.is_object()) Refuse("{} is not an object", where);
  for (const auto& [key, value] : json.items())
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) Refuse("{} has an unknown key '{}'", where, key);
}

template <typename Value>
std::optional<Value> Optional(const Json& json, const std::string& key) {
  return json.contains(key) ? std::optional(json.at(key).get<Value>()) : std::nullopt;
}

RecordedCamera CameraFrom(const Json& json) {
  RefuseOtherKeys(
      json, "a camera",
      {"id", "width_px", "height_px", "serial", "model", "lens", "pixel_format", "focus_m", "temperature_celsius"});
  constexpr int kMaxSide_px = std::numeric_limits<int>::max();
  RecordedCamera camera;
  camera.id = json.at("id").get<std::string>();
  camera.width_px = WholeNumber(json.at("width_px"), 1, kMaxSide_px, "width_px");
  camera.height_px = WholeNumber(json.at("height_px"), 1, kMaxSide_px, "height_px");
  camera.serial = json.value("serial", "");
  camera.model = json.value("model", "");
  camera.lens = json.value("lens", "");
  camera.pixel_format = json.value("pixel_format", "");
  camera.focus_m = Optional<double>(json, "focus_m");
  camera.temperature_celsius = Optional<double>(json, "temperature_celsius");
  return camera;
}

AxisPosition AxisFrom(const Json& json, const std::string& where) {
  RefuseOtherKeys(json, where + ": an axis", {"axis", "commanded_rad", "commanded_m", "reported_rad", "reported_m"});
  AxisPosition position;
  position.axis = json.at("axis").get<std::string>();
  position.unit = json.contains("commanded_rad") ? AxisUnit::kRadian : AxisUnit::kMetre;
  const char* other = Suffix(position.unit == AxisUnit::kRadian ? AxisUnit::kMetre : AxisUnit::kRadian);
  for (const char* key : {"commanded", "reported"})
    if (json.contains(key + std::string(other)))
      Refuse("{}: axis '{}' has values in both radians and metres", where, position.axis);
  const std::string suffix = Suffix(position.unit);
  position.commanded = json.at("commanded" + suffix).get<double>();
  position.reported = Optional<double>(json, "reported" + suffix);
  return position;
}

std::optional<Rigid3d> OptionalPose(const Json& json, const char* key, const std::string& where) {
  if (!json.contains(key)) return std::nullopt;
  RefuseOtherKeys(json.at(key), where + ": its pose", {"rotation", kTranslation});
  return PoseFrom(json.at(key), kTranslation, where);
}

RecordedStop StopFrom(const Json& json) {
  RefuseOtherKeys(json, "a stop", {"id", "axes", "base_from_flange_commanded", "base_from_flange_reported"});
  RecordedStop stop;
  stop.id = json.at("id").get<std::string>();
  const std::string where = fmt::format("stop '{}'", stop.id);
  if (json.contains("axes"))
    for (const Json& axis : List(json, "axes")) stop.axes.push_back(AxisFrom(axis, where));
  stop.base_from_flange_commanded = OptionalPose(json, "base_from_flange_commanded", where);
  stop.base_from_flange_reported = OptionalPose(json, "base_from_flange_reported", where);
  return stop;
}

using IndexById = std::map<std::string, int>;

int IndexOf(const IndexById& index_by_id, const std::string& id, const char* what, const std::string& where) {
  const auto found = index_by_id.find(id);
  if (found == index_by_id.end()) Refuse("{}: there is no {} '{}'", where, what, id);
  return found->second;
}

Subject SubjectFrom(const std::string& name, const std::string& where) {
  for (const auto& [known, subject] : kSubjects)
    if (name == known) return subject;
  Refuse("{}: its subject is '{}', must be chart, object or both", where, name);
}

RecordedView ViewFrom(const Json& json, const IndexById& cameras, const IndexById& stops) {
  RefuseOtherKeys(json, "a view",
                  {"file", "camera", "stop", "subject", "sha256", "exposure_us", "gain_db", "taken_at"});
  RecordedView view;
  view.file = json.at("file").get<std::string>();
  const std::string where = fmt::format("view '{}'", view.file);
  view.camera = IndexOf(cameras, json.at("camera").get<std::string>(), "camera", where);
  if (json.contains("stop")) view.stop = IndexOf(stops, json.at("stop").get<std::string>(), "stop", where);
  view.subject = SubjectFrom(json.at("subject").get<std::string>(), where);
  view.sha256 = json.at("sha256").get<std::string>();
  view.exposure_us = Optional<double>(json, "exposure_us");
  view.gain_db = Optional<double>(json, "gain_db");
  view.taken_at = Optional<std::string>(json, "taken_at");
  return view;
}

Recording RecordingFrom(const Json& json) {
  RefuseOtherKeys(json, "the recording", {"format", "version", "id", "closed", "linear", "cameras", "stops", "views"});
  Recording recording;
  recording.id = json.at("id").get<std::string>();
  recording.closed = json.at("closed").get<bool>();
  recording.linear = json.at("linear").get<bool>();
  IndexById cameras, stops;
  for (const Json& camera : List(json, "cameras")) {
    recording.cameras.push_back(CameraFrom(camera));
    cameras.emplace(recording.cameras.back().id, static_cast<int>(cameras.size()));
  }
  for (const Json& stop : List(json, "stops")) {
    recording.stops.push_back(StopFrom(stop));
    stops.emplace(recording.stops.back().id, static_cast<int>(stops.size()));
  }
  for (const Json& view : List(json, "views")) recording.views.push_back(ViewFrom(view, cameras, stops));
  if (const Result<void> consistent = CheckConsistent(recording); !consistent)
    throw BadContent(consistent.error().message);
  return recording;
}

}  // namespace

const char* NameOf(Subject subject) {
  for (const auto& [name, known] : kSubjects)
    if (known == subject) return name;
  Ensure(false, "every subject has a name");
  return "";
}

std::string RecordingText(const Recording& recording) {
  Json json = {{"format", kFormat.name},
               {"version", kFormat.version},
               {"id", recording.id},
               {"closed", recording.closed},
               {"linear", recording.linear}};
  for (const char* key : {"cameras", "stops", "views"}) json[key] = Json::array();
  for (const RecordedCamera& camera : recording.cameras) json["cameras"].push_back(CameraJson(camera));
  for (const RecordedStop& stop : recording.stops) json["stops"].push_back(StopJson(stop));
  for (const RecordedView& view : recording.views) json["views"].push_back(ViewJson(view, recording));
  return JsonText(json);
}

Result<Recording> ParseRecording(std::string_view text, const std::string& file) {
  return ReadDocument<Recording>(text, file, kFormat, RecordingFrom);
}

Result<Recording> LoadRecording(const std::filesystem::path& folder) {
  const Result<std::string> text = ReadFile(folder / kRecordingFile);
  if (!text) return Fail(text.error());
  return ParseRecording(*text, (folder / kRecordingFile).string());
}

}  // namespace rigcal
