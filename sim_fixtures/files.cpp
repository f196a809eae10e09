#include "sim_fixtures/files.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

namespace rigcal::sim {
namespace {

using Json = nlohmann::ordered_json;

Json AsJson(const Camera& camera) {
  return {{"id", camera.id},
          {"width_px", camera.width_px},
          {"height_px", camera.height_px},
          {"fx_px", camera.fx_px},
          {"fy_px", camera.fy_px},
          {"cx_px", camera.cx_px},
          {"cy_px", camera.cy_px},
          {"k1", camera.k1},
          {"k2", camera.k2},
          {"p1", camera.p1},
          {"p2", camera.p2},
          {"k3", camera.k3}};
}

Json AsJson(const Rigid3d& pose) {
  return {{"rotation_wxyz", {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()}},
          {"translation_m", {pose.translation.x(), pose.translation.y(), pose.translation.z()}}};
}

Json AsJson(const StudioOptions& o) {
  return {{"scene", NameOf(o.scene)},
          {"motion", NameOf(o.motion)},
          {"background", NameOf(o.surroundings)},
          {"cameras", o.num_cameras},
          {"stops", o.num_stops},
          {"views", o.num_views},
          {"width_px", o.width_px},
          {"height_px", o.height_px},
          {"distortion", o.distortion},
          {"step_error_deg", o.step_error_deg},
          {"random_seed", o.random_seed},
          {"cell_m", o.cell_m}};
}

}  // namespace

Result<void> WriteWhole(const std::filesystem::path& file, std::string_view bytes) {
  std::filesystem::path partial = file;
  partial += fmt::format(".partial{}", getpid());
  errno = 0;
  std::ofstream stream(partial, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  std::error_code failed;
  if (stream) std::filesystem::rename(partial, file, failed);
  if (stream && !failed) return {};
  const int cause = failed ? failed.value() : errno;
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  return Fail(cause == ENOSPC ? ErrorCode::kDiskFull : ErrorCode::kIo, "{}: cannot be written ({})", file.string(),
              std::strerror(cause));
}

std::string MiddleburyText(const RigCalibration& calibration) {
  std::string text = fmt::format("{}\n", calibration.NumViews());
  for (int i = 0; i < calibration.NumViews(); ++i) {
    const View& view = calibration.views[i];
    const Eigen::Matrix3d k = calibration.CameraOf(i).CalibrationMatrix();
    const Eigen::Matrix3d r = view.cam_from_world.rotation.toRotationMatrix();
    text += view.name;
    for (const Eigen::Matrix3d& matrix : {k, r}) {
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) text += fmt::format(" {:.17g}", matrix(row, column));
      }
    }
    for (int row = 0; row < 3; ++row) text += fmt::format(" {:.17g}", view.cam_from_world.translation[row]);
    text += '\n';
  }
  return text;
}

std::string PointsText(const std::vector<VisiblePoint>& points) {
  std::string text;
  for (const VisiblePoint& point : points) {
    text += fmt::format("{:.9g} {:.9g} {:.9g} {}", point.x_in_world.x(), point.x_in_world.y(), point.x_in_world.z(),
                        point.views.size());
    for (const int view : point.views) text += fmt::format(" {}", view);
    text += '\n';
  }
  return text;
}

Json TruthJson(const Studio& studio, const FolderOptions& options) {
  Json json;
  json["studio"] = AsJson(studio.options);
  json["sensor"] = {{"samples_per_side", options.samples_per_side},
                    {"blur_sigma_px", options.sensor.blur_sigma_px},
                    {"noise_sigma", options.sensor.noise_sigma},
                    {"linear", options.sensor.linear},
                    {"bits", options.sensor.bits}};
  json["frame"] = "world: the table top, origin on the axis, +z up; x_in_stage = stage_from_world * x_in_world";
  json["unit"] = "m";
  json["axis_in_world"] = {{"origin_m", {0, 0, 0}}, {"direction", {0, 0, 1}}};
  json["table_radius_m"] = studio.table_radius_m;
  json["cameras"] = Json::array();
  for (const Camera& camera : studio.truth.cameras) json["cameras"].push_back(AsJson(camera));
  json["views"] = Json::array();
  for (int i = 0; i < studio.truth.NumViews(); ++i) {
    const View& view = studio.truth.views[i];
    json["views"].push_back({{"name", view.name},
                             {"camera", studio.truth.CameraOf(i).id},
                             {"cam_from_world", AsJson(view.cam_from_world)},
                             {"table_angle_rad", studio.table_angle_rad[i]}});
  }
  return json;
}

Result<StudioOptions> StudioOptionsFromJson(const nlohmann::json& truth) {
  try {
    const nlohmann::json& json = truth.at("studio");
    StudioOptions options;
    const auto scene = SceneFromName(json.at("scene").get<std::string>());
    const auto motion = MotionFromName(json.at("motion").get<std::string>());
    const auto surroundings = SurroundingsFromName(json.at("background").get<std::string>());
    if (!scene || !motion || !surroundings) {
      return Fail(ErrorCode::kBadInput, "studio: scene, motion or background has an unknown name");
    }
    options.scene = *scene;
    options.motion = *motion;
    options.surroundings = *surroundings;
    json.at("cameras").get_to(options.num_cameras);
    json.at("stops").get_to(options.num_stops);
    json.at("views").get_to(options.num_views);
    json.at("width_px").get_to(options.width_px);
    json.at("height_px").get_to(options.height_px);
    json.at("distortion").get_to(options.distortion);
    json.at("step_error_deg").get_to(options.step_error_deg);
    json.at("random_seed").get_to(options.random_seed);
    json.at("cell_m").get_to(options.cell_m);
    return options;
  } catch (const nlohmann::json::exception& error) {
    return Fail(ErrorCode::kBadInput, "{}", error.what());
  }
}

}  // namespace rigcal::sim
