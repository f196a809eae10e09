#include "sim_fixtures/truth_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

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

Json AsJson(const std::vector<Fault>& faults) {
  Json list = Json::array();
  for (const Fault& fault : faults) list.push_back({{"index", fault.index}, {"angle_deg", fault.angle_deg}});
  return list;
}

/// What sets may have besides: only what is used is written, so that others stay as they were to the byte.
bool HasStopErrorsBesidesSteps(const StudioOptions& o) {
  return o.wobble_deg != 0 || o.run_out_mm != 0 || !o.slips.empty();
}

Json AsJson(const StudioOptions& o) {
  Json json = {{"scene", NameOf(o.scene)},
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
  if (o.wobble_deg != 0) json["wobble_deg"] = o.wobble_deg;
  if (o.run_out_mm != 0) json["run_out_mm"] = o.run_out_mm;
  if (o.object) json["object"] = NameOf(*o.object);
  if (o.object_variant != 0) json["object_variant"] = o.object_variant;
  if (!o.bumps.empty()) json["bumps"] = AsJson(o.bumps);
  for (const PixelBump& bump : o.pixel_bumps) {
    json["pixel_bumps"].push_back({{"index", bump.index}, {"shift_px", bump.shift_px}});
  }
  if (!o.slips.empty()) json["slips"] = AsJson(o.slips);
  return json;
}

std::vector<Fault> FaultsFrom(const nlohmann::json& studio, const char* key) {
  std::vector<Fault> faults;
  for (const nlohmann::json& fault : studio.value(key, nlohmann::json::array())) {
    faults.push_back({fault.at("index").get<int>(), fault.at("angle_deg").get<double>()});
  }
  return faults;
}

Result<StudioOptions> StudioOptionsFrom(const nlohmann::json& json) {
  StudioOptions options;
  const auto scene = SceneFromName(json.at("scene").get<std::string>());
  const auto motion = MotionFromName(json.at("motion").get<std::string>());
  const auto surroundings = SurroundingsFromName(json.at("background").get<std::string>());
  if (!scene || !motion || !surroundings) {
    return Fail(ErrorCode::kBadInput, "studio.scene, studio.motion or studio.background has an unknown name");
  }
  if (json.contains("object")) {
    options.object = SceneFromName(json.at("object").get<std::string>());
    if (!options.object) return Fail(ErrorCode::kBadInput, "studio.object has an unknown name");
  }
  options.object_variant = json.value("object_variant", 0);
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
  options.wobble_deg = json.value("wobble_deg", 0.0);
  options.run_out_mm = json.value("run_out_mm", 0.0);
  options.bumps = FaultsFrom(json, "bumps");
  for (const nlohmann::json& bump : json.value("pixel_bumps", nlohmann::json::array())) {
    options.pixel_bumps.push_back({bump.at("index").get<int>(), bump.at("shift_px").get<double>()});
  }
  options.slips = FaultsFrom(json, "slips");
  json.at("random_seed").get_to(options.random_seed);
  json.at("cell_m").get_to(options.cell_m);
  return options;
}

Json StopsAsJson(const Studio& studio) {
  Json stops = Json::array();
  for (std::size_t i = 0; i < studio.stop_errors.size(); ++i) {
    const StopError& error = studio.stop_errors[i];
    stops.push_back({{"commanded_rad", studio.commanded_rad[i]},
                     {"wobble_rad", {error[kWobbleX], error[kWobbleY]}},
                     {"step_error_rad", error[kStep]},
                     {"run_out_m", {error[kRunOutX], error[kRunOutY]}}});
  }
  return stops;
}

Json AsJson(const Chart& chart, const ChartOptions& options, const std::vector<Camera>& cameras) {
  const Board& board = options.print.board;
  Json json = {
      {"board",
       {{"family", board.family},
        {"border_bits", board.border_bits},
        {"columns", board.columns},
        {"rows", board.rows},
        {"tag_m", board.tag_m},
        {"gap_m", board.gap_m},
        {"first_id", board.first_id},
        {"thickness_m", board.thickness_m}}},
      {"shape",
       {{"bow_x_m", options.shape.bow_x_m}, {"bow_y_m", options.shape.bow_y_m}, {"stretch", options.shape.stretch}}},
      {"tilt_deg", options.tilt_deg},
      {"world_from_board", AsJson(chart.world_from_board)}};
  json["hand_held"] = Json::array();
  for (const HandHeldView& view : chart.hand_held) {
    json["hand_held"].push_back(
        {{"name", view.name}, {"camera", cameras[view.camera].id}, {"cam_from_board", AsJson(view.cam_from_board)}});
  }
  return json;
}

/// Largest difference (metres, quaternion components) between the poses of truth.json and those of a studio.
double LargestDifference(const RigCalibration& truth, const nlohmann::json& views) {
  if (views.size() != truth.views.size()) return 1;
  double largest = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const nlohmann::json& pose = views[i].at("cam_from_world");
    const Rigid3d& own = truth.views[i].cam_from_world;
    for (int axis = 0; axis < 3; ++axis) {
      const double translation = pose.at("translation_m").at(axis).get<double>();
      const double rotation = pose.at("rotation_wxyz").at(axis + 1).get<double>();
      largest = std::max(
          {largest, std::abs(translation - own.translation[axis]), std::abs(rotation - own.rotation.vec()[axis])});
    }
  }
  return largest;
}

}  // namespace

std::string TruthText(const Studio& studio, const ShotOptions& shot) {
  Json json;
  json["studio"] = AsJson(studio.options);
  json["sensor"] = {{"samples_per_side", shot.samples_per_side},
                    {"blur_sigma_px", shot.sensor.blur_sigma_px},
                    {"noise_sigma", shot.sensor.noise_sigma},
                    {"linear", shot.sensor.linear},
                    {"bits", shot.sensor.bits}};
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
  if (!studio.stop_errors.empty() && (studio.chart || HasStopErrorsBesidesSteps(studio.options))) {
    json["stops"] = StopsAsJson(studio);
  }
  if (studio.chart) json["chart"] = AsJson(*studio.chart, *studio.options.chart, studio.truth.cameras);
  return json.dump(2) + "\n";
}

Result<Studio> StudioFromTruth(std::string_view text, const std::string& file, const Execution& execution) {
  constexpr double kSamePlace = 1e-6;  // metres and quaternion components: far below a pixel
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_discarded()) return Fail(ErrorCode::kBadInput, "{}: is not JSON", file);
  try {
    if (json.contains("chart")) {
      return Fail(ErrorCode::kBadInput, "{}: is of a chart, only studios with an object can be made again", file);
    }
    const auto options = StudioOptionsFrom(json.at("studio"));
    if (!options) return Fail(options.error().code, "{}: {}", file, options.error().message);
    auto studio = MakeStudio(*options, execution);
    if (!studio) return Fail(studio.error());
    const double difference = LargestDifference(studio->truth, json.at("views"));
    if (difference > kSamePlace) {
      return Fail(ErrorCode::kBadInput, "{}: its poses differ by {} (limit {}) from those of this version's studio",
                  file, difference, kSamePlace);
    }
    return studio;
  } catch (const nlohmann::json::exception& error) {
    return Fail(ErrorCode::kBadInput, "{}: {}", file, error.what());
  }
}

}  // namespace rigcal::sim
