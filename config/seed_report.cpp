#include "config/seed_report.h"

#include <fmt/format.h>

#include <numbers>

#include "config/json_text.h"
#include "core/base/ensure.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;
constexpr double kDegPerRad = 180 / std::numbers::pi;

IntrinsicVector SigmaOf(const RigCalibration& calibration, int camera) {
  return calibration.covariance ? calibration.covariance->IntrinsicsSigma(camera) : IntrinsicVector::Zero();
}

Json CamerasJson(const SeedResult& seed) {
  Json json = Json::array();
  for (int c = 0; c < seed.calibration.NumCameras(); ++c) {
    const Camera& camera = seed.calibration.cameras[c];
    const SeedCameraReport& report = seed.report.cameras[c];
    Json entry = {{"id", camera.id}, {"width_px", camera.width_px}, {"height_px", camera.height_px}};
    entry.update(IntrinsicsJson(camera.Intrinsics()));
    entry["sigma"] = IntrinsicsJson(SigmaOf(seed.calibration, c));
    entry.update({{"num_views", report.num_views},
                  {"num_corners", report.num_corners},
                  {"num_outliers", report.num_outliers},
                  {"rms_px", NumberJson(report.rms_px)},
                  {"noise_scale", NumberJson(report.noise_scale)},
                  {"uses_k3", report.uses_k3},
                  {"k3_gain", NumberJson(report.k3_gain)},
                  {"k3_cost", NumberJson(report.k3_cost)},
                  {"coverage", NumberJson(report.coverage)},
                  {"max_tilt_deg", NumberJson(report.max_tilt_rad * kDegPerRad)}});
    json.push_back(std::move(entry));
  }
  return json;
}

Json ViewsJson(const SeedScene& scene, const std::vector<ChartDetection>& detections, const SeedReport& report) {
  Json json = Json::array();
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    Json findings = Json::array();
    for (const ChartFinding& finding : detections[v].findings) findings.push_back(finding.message);
    json.push_back({{"name", scene.views[v].name},
                    {"camera", scene.cameras[scene.views[v].camera].id},
                    {"num_tags", detections[v].num_tags},
                    {"num_predicted_tags", detections[v].num_predicted},
                    {"num_corners", detections[v].corners.size()},
                    {"blur_px", NumberJson(detections[v].blur_px)},
                    {"rms_px", NumberJson(report.view_rms_px[v])},
                    {"findings", std::move(findings)}});
  }
  return json;
}

Json BoardJson(const SeedResult& seed) {
  const BoardShape &shape = seed.board_shape, &sigma = seed.board_shape_sigma;
  return {{"bow_x_m", shape.bow_x_m},
          {"bow_y_m", shape.bow_y_m},
          {"stretch", shape.stretch},
          {"sigma",
           {{"bow_x_m", NumberJson(sigma.bow_x_m)},
            {"bow_y_m", NumberJson(sigma.bow_y_m)},
            {"stretch", NumberJson(sigma.stretch)}}}};
}

Json VectorJson(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json AxisJson(const AxisEstimate& axis, const SeedScene& scene) {
  return {{"camera", scene.cameras[axis.camera].id},
          {"direction_in_cam", VectorJson(axis.direction_in_cam)},
          {"direction_sigma_deg", NumberJson(axis.direction_sigma_rad * kDegPerRad)},
          {"point_in_cam_m", VectorJson(axis.point_in_cam)},
          {"point_sigma_m", NumberJson(axis.point_sigma_m)}};
}

/// The errors of a stop that this kind of positioner has; rotations in degrees.
Json StopErrorsJson(const Positioner& positioner, const StopError& error, const StopError& sigma) {
  constexpr int kNumRotations = 3;
  Json json = Json::array();
  const auto names = StopErrorNames(positioner);
  for (int k = 0; k < kStopErrorSize; ++k) {
    if (*names[k] == '\0') continue;
    const bool turns = k < kNumRotations;
    const double scale = turns ? kDegPerRad : 1;
    json.push_back({{"name", names[k]},
                    {"value", NumberJson(scale * error[k])},
                    {"sigma", NumberJson(scale * sigma[k])},
                    {"unit", turns ? "deg" : "m"}});
  }
  return json;
}

Json RigJson(const SeedScene& scene, const RigEstimate& rig) {
  Json json;
  if (rig.axis) json["axis"] = AxisJson(*rig.axis, scene);
  json["stops"] = Json::array();
  for (std::size_t s = 0; s < scene.stops.size(); ++s) {
    json["stops"].push_back(
        {{"id", scene.stops[s].id},
         {"errors", StopErrorsJson(rig.model.positioner, rig.stop_errors[s], rig.stop_error_sigma[s])}});
  }
  return json;
}

std::string AxisText(const AxisEstimate& axis, const SeedScene& scene) {
  const Eigen::Vector3d &d = axis.direction_in_cam, &p = axis.point_in_cam;
  return fmt::format(
      "axis in camera {}: direction ({:.6f}, {:.6f}, {:.6f}) +- {:.4f} degrees, through ({:.3f}, {:.3f}, {:.3f}) +- "
      "{:.3f} mm\n",
      scene.cameras[axis.camera].id, d.x(), d.y(), d.z(), axis.direction_sigma_rad * kDegPerRad, 1e3 * p.x(),
      1e3 * p.y(), 1e3 * p.z(), 1e3 * axis.point_sigma_m);
}

}  // namespace

std::string SeedReportText(const SeedScene& scene, const std::vector<ChartDetection>& detections,
                           const SeedResult& seed) {
  Ensure(detections.size() == scene.views.size(), "there is one detection per view");
  Json json = {{"format", "rigcal seed report"},
               {"version", kVersion},
               {"rms_px", NumberJson(seed.report.rms_px)},
               {"cameras", CamerasJson(seed)},
               {"views", ViewsJson(scene, detections, seed.report)},
               {"board", BoardJson(seed)},
               {"advice", seed.report.advice},
               {"contradictions", seed.report.contradictions}};
  if (seed.rig) json["rig"] = RigJson(scene, *seed.rig);
  return JsonText(json);
}

std::string SeedSummaryText(const SeedScene& scene, const SeedResult& seed) {
  std::string text = fmt::format("chart corners: {:.3f} px RMS\n", seed.report.rms_px);
  for (int c = 0; c < seed.calibration.NumCameras(); ++c) {
    const Camera& camera = seed.calibration.cameras[c];
    const SeedCameraReport& report = seed.report.cameras[c];
    const IntrinsicVector sigma = SigmaOf(seed.calibration, c);
    text += fmt::format(
        "camera {}: fx {:.2f} +- {:.2f}, fy {:.2f} +- {:.2f}, cx {:.2f} +- {:.2f}, cy {:.2f} +- {:.2f} px; {} views, "
        "{} corners, "
        "{:.3f} px RMS\n",
        camera.id, camera.fx_px, sigma[kFx], camera.fy_px, sigma[kFy], camera.cx_px, sigma[kCx], camera.cy_px,
        sigma[kCy], report.num_views, report.num_corners, report.rms_px);
  }
  if (seed.rig && seed.rig->axis) text += AxisText(*seed.rig->axis, scene);
  for (const std::string& sentence : seed.report.contradictions) text += sentence + "\n";
  for (const std::string& sentence : seed.report.advice) text += sentence + "\n";
  return text;
}

}  // namespace rigcal
