#include "config/seed_report.h"

#include <fmt/format.h>

#include <numbers>

#include "config/json_text.h"
#include "config/rig_report.h"
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

Json AxisOnBoardJson(const AxisOnBoard& axis) {
  const Eigen::Vector3d& d = axis.direction_in_board;
  return {{"direction_in_board", {d.x(), d.y(), d.z()}},
          {"direction_sigma_deg", NumberJson(axis.direction_sigma_rad * kDegPerRad)},
          {"point_in_board_m", {axis.point_in_board.x(), axis.point_in_board.y()}},
          {"point_sigma_m", NumberJson(axis.point_sigma_m)}};
}

std::vector<std::string> CameraIds(const SeedScene& scene) {
  std::vector<std::string> ids;
  for (const SeedCamera& camera : scene.cameras) ids.push_back(camera.id);
  return ids;
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
  if (seed.rig) json["rig"] = RigFitJson(*seed.rig, CameraIds(scene));
  if (seed.axis_on_board) json["rig"]["axis_on_board"] = AxisOnBoardJson(*seed.axis_on_board);
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
  if (seed.rig && seed.rig->axis) text += AxisText(*seed.rig->axis, CameraIds(scene));
  if (const auto& axis = seed.axis_on_board) {
    text +=
        fmt::format("axis on the board: through ({:.3f}, {:.3f}) +- {:.4f} mm, its direction known to {:.4f} degrees\n",
                    1e3 * axis->point_in_board.x(), 1e3 * axis->point_in_board.y(), 1e3 * axis->point_sigma_m,
                    axis->direction_sigma_rad * kDegPerRad);
  }
  for (const std::string& sentence : seed.report.contradictions) text += sentence + "\n";
  for (const std::string& sentence : seed.report.advice) text += sentence + "\n";
  return text;
}

}  // namespace rigcal
