#include "config/rig_report.h"

#include <numbers>

#include "config/json_text.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegPerRad = 180 / std::numbers::pi;

Json VectorJson(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json AxisJson(const AxisEstimate& axis, const std::vector<std::string>& camera_ids) {
  return {{"camera", camera_ids[axis.camera]},
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

}  // namespace

Json RigFitJson(const RigFit& fit, const std::vector<std::string>& camera_ids) {
  Json json;
  if (fit.axis) json["axis"] = AxisJson(*fit.axis, camera_ids);
  json["stops"] = Json::array();
  for (std::size_t s = 0; s < fit.stop_ids.size(); ++s) {
    json["stops"].push_back({{"id", fit.stop_ids[s]},
                             {"errors", StopErrorsJson(fit.positioner, fit.stop_errors[s], fit.stop_error_sigma[s])}});
  }
  return json;
}

std::string AxisText(const AxisEstimate& axis, const std::vector<std::string>& camera_ids) {
  const Eigen::Vector3d &d = axis.direction_in_cam, &p = axis.point_in_cam;
  return fmt::format(
      "axis in camera {}: direction ({:.6f}, {:.6f}, {:.6f}) +- {:.4f} degrees, through ({:.3f}, {:.3f}, {:.3f}) +- "
      "{:.3f} mm\n",
      camera_ids[axis.camera], d.x(), d.y(), d.z(), axis.direction_sigma_rad * kDegPerRad, 1e3 * p.x(), 1e3 * p.y(),
      1e3 * p.z(), 1e3 * axis.point_sigma_m);
}

}  // namespace rigcal
