#include "config/calibration_file.h"

#include <limits>
#include <map>

#include "config/atomic_file.h"
#include "config/covariance_json.h"
#include "config/json_content.h"
#include "config/json_text.h"
#include "config/provenance_json.h"
#include "config/rig_section.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr DocumentFormat kFormat = {"rigcal calibration", 1};
constexpr const char* kFrame =
    "x_in_cam = cam_from_world * x_in_world; camera +x right, +y down, +z forward; pixel (0,0) is the centre of the "
    "top-left pixel; distortion as in OpenCV";
constexpr const char* kCovarianceOrder =
    "for each camera fx fy cx cy skew k1 k2 p1 p2 k3, then for each view a rotation (rad) about and a shift along the "
    "camera's own x y z; rows not listed are 0";

Json CamerasJson(const RigCalibration& calibration) {
  Json cameras = Json::array();
  for (int c = 0; c < calibration.NumCameras(); ++c) {
    const Camera& camera = calibration.cameras[c];
    Json json = {{"id", camera.id}, {"physical_id", camera.physical_id}};
    json["width_px"] = camera.width_px, json["height_px"] = camera.height_px;
    json.update(IntrinsicsJson(camera.Intrinsics()));
    if (calibration.covariance) json["sigma"] = IntrinsicsJson(calibration.covariance->IntrinsicsSigma(c));
    cameras.push_back(std::move(json));
  }
  return cameras;
}

Json ViewsJson(const RigCalibration& calibration) {
  Json views = Json::array();
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    Json pose = PoseJson(view.cam_from_world, "translation");
    views.push_back({{"name", view.name}, {"camera", calibration.CameraOf(v).id}, {"cam_from_world", std::move(pose)}});
  }
  return views;
}

Camera CameraFrom(const Json& json) {
  Camera camera;
  camera.id = json.at("id").get<std::string>();
  camera.physical_id = json.value("physical_id", camera.id);
  camera.width_px = WholeNumber(json.at("width_px"), 1, std::numeric_limits<int>::max(), "width_px");
  camera.height_px = WholeNumber(json.at("height_px"), 1, std::numeric_limits<int>::max(), "height_px");
  IntrinsicVector intrinsics;
  for (int i = 0; i < kNumIntrinsics; ++i) intrinsics[i] = json.at(kIntrinsicKeys[i]).get<double>();
  camera.SetIntrinsics(intrinsics);
  return camera;
}

LengthUnit UnitFrom(const Json& json) {
  const auto unit = json.get<std::string>();
  if (unit != "m" && unit != "unknown") Refuse("the unit is '{}', 'm' or 'unknown' is needed", unit);
  return unit == "m" ? LengthUnit::kMetre : LengthUnit::kUnknown;
}

CalibrationContent ContentFrom(const Json& json, const std::string& file) {
  CalibrationContent content;
  RigCalibration& calibration = content.calibration;
  std::map<std::string, int> camera_by_id;
  for (const Json& camera : List(json, "cameras")) {
    calibration.cameras.push_back(CameraFrom(camera));
    if (!camera_by_id.emplace(calibration.cameras.back().id, calibration.NumCameras() - 1).second)
      Refuse("the camera '{}' is there twice", calibration.cameras.back().id);
  }
  for (const Json& view : List(json, "views")) {
    const auto name = view.at("name").get<std::string>();
    const std::string where = fmt::format("{} view '{}'", file, name);
    const auto camera = camera_by_id.find(view.at("camera").get<std::string>());
    if (camera == camera_by_id.end())
      Refuse("view '{}': there is no camera '{}'", name, view.at("camera").get<std::string>());
    calibration.views.push_back({name, camera->second, PoseFrom(view.at("cam_from_world"), "translation", where)});
    const View& added = calibration.views.back();
    content.records.push_back({name, where, calibration.cameras[added.camera], added.cam_from_world});
  }
  calibration.unit = UnitFrom(json.at("unit"));
  if (json.contains("covariance"))
    calibration.covariance = CalibrationCovariance{CovarianceFrom(
        json.at("covariance"), CalibrationCovariance::PoseRow(calibration.NumCameras(), calibration.NumViews()))};
  if (json.contains("rig")) calibration.rig = RigSectionFrom(json.at("rig"), calibration.cameras, file);
  if (json.contains("provenance")) content.provenance = ProvenanceFrom(json.at("provenance"));
  return content;
}

}  // namespace

std::string CalibrationText(const RigCalibration& calibration, const Provenance& provenance) {
  Json json = {{"format", kFormat.name}, {"version", kFormat.version}, {"frame", kFrame}};
  json["unit"] = calibration.unit == LengthUnit::kMetre ? "m" : "unknown";
  json["cameras"] = CamerasJson(calibration);
  json["views"] = ViewsJson(calibration);
  json["provenance"] = ProvenanceJson(provenance);
  if (calibration.covariance) json["covariance"] = CovarianceJson(calibration.covariance->joint, kCovarianceOrder);
  if (calibration.rig) json["rig"] = RigSectionJson(*calibration.rig, calibration.cameras);
  return JsonText(json);
}

Result<void> WriteCalibration(const std::filesystem::path& path, const RigCalibration& calibration,
                              const Provenance& provenance) {
  return WriteFileAtomically(path, CalibrationText(calibration, provenance));
}

Result<CalibrationContent> ParseCalibration(std::string_view text, const std::string& file) {
  return ReadDocument<CalibrationContent>(text, file, kFormat,
                                          [&file](const Json& json) { return ContentFrom(json, file); });
}

}  // namespace rigcal
