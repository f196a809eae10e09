#include "core/seed/rig_contradictions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/base/joined.h"
#include "core/seed/own_pose.h"

namespace rigcal {
namespace {

/// A view whose residuals are this many times its camera's noise, and what they would be with a pose of its own, does
/// not fit the rig: a factor that neither noise nor a bent board reaches (0.1 px of noise: a shift of 0.2 px). Corners
/// of a board that is seen at a grazing angle are noisier than the rest, whatever the pose.
constexpr double kMisfitRatio = 2.5;
/// Sigma of a stop error that lost its prior, in sizes of the error found.
constexpr double kReleasedSigmas = 100;
/// Root mean square of the stops' errors over their stated sigma above which the rig file understates them: with six
/// stops chance exceeds it once in 2000 for each component.
constexpr double kUnderstatedRatio = 2;
constexpr int kLeastStopsToJudge = 6;

double Degrees(double angle_rad) {
  return angle_rad * 180 / std::numbers::pi;
}

std::string WithUnit(double value, int component) {
  return component < 3 ? fmt::format("{:.3f} deg", Degrees(value)) : fmt::format("{:.3f} mm", 1e3 * value);
}

/// Cameras that saw the chart at a stop.
std::set<int> CamerasAt(const ChartTerms& terms, int stop) {
  std::set<int> cameras;
  for (const ChartView& view : terms.views) {
    if (view.stop == stop && !view.corners.empty()) cameras.insert(view.camera);
  }
  return cameras;
}

std::vector<std::string> ReleaseSlippedStops(const SeedScene& scene, const SeedOptions& options,
                                             const ChartState& state, ChartTerms& terms) {
  std::vector<std::string> sentences;
  const auto names = StopErrorNames(scene.rig->positioner);
  for (std::size_t s = 0; s < terms.stops.size(); ++s) {
    const std::set<int> cameras = CamerasAt(terms, static_cast<int>(s));
    if (cameras.empty()) continue;  // all its views were taken out, and that was said
    int worst = -1;
    double worst_ratio = options.contradiction_sigmas;
    for (int k = 0; k < kStopErrorSize; ++k) {
      const double sigma = terms.stop_error_sigma[s][k];
      if (sigma > 0 && std::abs(state.stop_errors[s][k]) > worst_ratio * sigma) {
        worst = k, worst_ratio = std::abs(state.stop_errors[s][k]) / sigma;
      }
    }
    if (worst < 0) continue;
    const std::string fault =
        cameras.size() > 1
            ? "the positioner slipped or was moved there"
            : fmt::format("the positioner slipped or camera {} moved, which one camera alone cannot tell",
                          scene.cameras[*cameras.begin()].id);
    sentences.push_back(fmt::format("stop {}: {} of {}, {:.0f} times what the rig states ({}): {}", terms.stops[s].id,
                                    names[worst], WithUnit(state.stop_errors[s][worst], worst), worst_ratio,
                                    WithUnit(terms.stop_error_sigma[s][worst], worst), fault));
    for (int k = 0; k < kStopErrorSize; ++k) {
      double& sigma = terms.stop_error_sigma[s][k];
      if (sigma > 0) sigma = std::max(sigma, kReleasedSigmas * std::abs(state.stop_errors[s][k]));
    }
  }
  return sentences;
}

/// Views at stops, by stop: which fit and which do not.
struct StopFit {
  std::vector<int> fitting, misfitting;
};

std::map<int, StopFit> FitByStop(const ChartTerms& terms, const ChartState& state) {
  const CornerResiduals residuals = ResidualsOf(terms, state);
  std::map<int, StopFit> by_stop;
  for (int v = 0; v < static_cast<int>(terms.views.size()); ++v) {
    const ChartView& view = terms.views[v];
    if (!view.stop || view.corners.empty()) continue;
    const double scale = RobustScale(residuals.stated_sigmas[v]);
    const bool misfit = scale > kMisfitRatio * terms.noise_scale[view.camera] &&
                        scale > kMisfitRatio * ScaleWithOwnPose(terms, state, v);
    (misfit ? by_stop[*view.stop].misfitting : by_stop[*view.stop].fitting).push_back(v);
  }
  return by_stop;
}

std::string Listed(const std::vector<std::string>& ids) {
  return fmt::format("{} {}", ids.size() == 1 ? "stop" : "stops", Joined(ids, ", "));
}

}  // namespace

std::vector<std::string> TakeOutContradictions(const SeedScene& scene, const SeedOptions& options,
                                               const ChartState& state, ChartTerms& terms) {
  std::map<int, std::vector<std::string>> moved, undecided;  // per camera: the stops
  std::map<int, double> turn_rad;
  std::vector<std::string> of_all;
  const auto by_stop = FitByStop(terms, state);
  for (const auto& [s, fit] : by_stop) {
    const std::string& id = terms.stops[s].id;
    if (fit.misfitting.size() >= 2 && fit.fitting.empty()) of_all.push_back(id);
    for (const int v : fit.misfitting) {
      const int camera = terms.views[v].camera;
      if (!fit.fitting.empty()) moved[camera].push_back(id);
      if (fit.fitting.empty() && fit.misfitting.size() == 1) undecided[camera].push_back(id);
      turn_rad[camera] = std::max(
          turn_rad[camera], CamFromBoard(terms, state, v).rotation.angularDistance(state.cam_from_board[v].rotation));
    }
  }
  std::vector<std::string> sentences;
  for (const auto& [camera, stops] : moved) {
    sentences.push_back(
        fmt::format("camera {} moved against the others, by up to {:.2f} deg: its pictures at {} do not fit "
                    "the rig, those of the other cameras there do",
                    scene.cameras[camera].id, Degrees(turn_rad[camera]), Listed(stops)));
  }
  if (!of_all.empty()) {
    sentences.push_back(fmt::format(
        "no camera's picture fits the rig at {}: the board or the positioner was moved there", Listed(of_all)));
  }
  for (const auto& [camera, stops] : undecided) {
    sentences.push_back(
        fmt::format("the pictures of camera {} at {} do not fit the rig and no other camera saw the chart "
                    "there: whether the camera or the board moved cannot be decided",
                    scene.cameras[camera].id, Listed(stops)));
  }
  for (const auto& [s, fit] : by_stop) {
    for (const int v : fit.misfitting) terms.views[v].stop.reset();
  }
  const auto slipped = ReleaseSlippedStops(scene, options, state, terms);
  sentences.insert(sentences.end(), slipped.begin(), slipped.end());
  return sentences;
}

std::vector<std::string> UnderstatedErrors(const SeedScene& scene, const ChartTerms& terms, const ChartState& state) {
  std::vector<std::string> sentences;
  const auto names = StopErrorNames(scene.rig->positioner);
  std::vector<bool> seen(terms.stops.size(), false);
  for (const ChartView& view : terms.views) {
    if (view.stop && !view.corners.empty()) seen[*view.stop] = true;
  }
  for (int k = 0; k < kStopErrorSize; ++k) {
    double sum2 = 0;
    int count = 0;
    for (std::size_t s = 0; s < terms.stops.size(); ++s) {
      const bool released = terms.stop_error_sigma[s][k] > scene.rig->error_sigma[k];
      if (seen[s] && !released) sum2 += state.stop_errors[s][k] * state.stop_errors[s][k], ++count;
    }
    const double rms = count > 0 ? std::sqrt(sum2 / count) : 0;
    if (count < kLeastStopsToJudge || !(rms > kUnderstatedRatio * scene.rig->error_sigma[k])) continue;
    sentences.push_back(
        fmt::format("{}: {} (root mean square over {} stops), the rig states {}: its figure is too small", names[k],
                    WithUnit(rms, k), count, WithUnit(scene.rig->error_sigma[k], k)));
  }
  return sentences;
}

}  // namespace rigcal
