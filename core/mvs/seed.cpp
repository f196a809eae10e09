#include "core/mvs/seed.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace rigcal::stereo {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// Views whose axes differ by more show another side of the object.
constexpr double kMaxAngleRad = 50 * kDegree;
constexpr std::size_t kMaxPartners = 4;
/// Half of the epipolar band in exact cameras: two features, each good for half a pixel (PMVS paper: 2 pixels).
constexpr double kBandPx = 1.5;
/// Points may be this many times further off than the mean error says (templeSparseRing: 14-19 px for a mean of 6).
constexpr double kPointsOverMean = 2.0;
constexpr float kMinPairNcc = 0.6f;
/// Best matches that are made into patches. With three templeSparseRing has 4,424 patches at level 2, with two 4,405.
constexpr std::size_t kMaxTrials = 2;

struct PairMatch {
  float ncc;
  WindowPlane plane;
  Sighting sighting;
};

/// A plane at a depth on the feature's ray whose normal halves the angle between the two cameras.
std::optional<WindowPlane> PlaneBetween(const StereoScene& scene, int view, const Feature& feature, int other,
                                        double w) {
  const WindowPlane at{view, feature.u_px, feature.v_px, {w, 0, 0}};
  const Eigen::Vector3d x = CentreInWorld(scene, at);
  const Eigen::Vector3d normal = (scene.TowardsCamera(view, x) + scene.TowardsCamera(other, x)).normalized();
  return PlaneThrough(scene, view, feature.u_px, feature.v_px, x, normal);
}

void MatchInView(const StereoScene& scene, const std::vector<Feature>& features, int view, const Feature& feature,
                 int other, const WindowTexture& texture, std::vector<PairMatch>& matches) {
  const PairGeometry& pair = scene.Pair(view, other);
  const Eigen::Vector3d far = pair.infinite_homography * Eigen::Vector3d(feature.u_px, feature.v_px, 1);
  Eigen::Vector3d line = far.cross(pair.epipole);
  const double length = line.head<2>().norm();
  if (!(length > 0)) return;
  line /= length;
  const Eigen::Vector2d along(-line.y(), line.x());
  const double band_px =
      kBandPx + kPointsOverMean * std::hypot(scene.views[view].error_px, scene.views[other].error_px);
  for (const Feature& candidate : features) {
    const Eigen::Vector2d g(candidate.u_px, candidate.v_px);
    if (std::abs(line.head<2>().dot(g) + line.z()) > band_px) continue;
    // The inverse depth whose projection lies nearest to the candidate: (far + w epipole) seen along the line.
    const double w =
        -(far.head<2>() - g * far.z()).dot(along) / (pair.epipole.head<2>() - g * pair.epipole.z()).dot(along);
    if (!(w > 0) || !(far.z() + w * pair.epipole.z() > 0)) continue;
    const std::optional<WindowPlane> plane = PlaneBetween(scene, view, feature, other, w);
    if (!plane) continue;
    const Eigen::Vector3d q = far + w * pair.epipole;
    const Eigen::Vector2f offset_px = (g - q.head<2>() / q.z()).cast<float>();
    const std::optional<WindowWarp> warp = MakeWarp(scene, *plane, other, offset_px);
    if (!warp) continue;
    const std::optional<float> ncc = WindowNcc(scene.views[other].gray, scene.options.window_px, *warp, texture);
    if (ncc && *ncc >= kMinPairNcc) matches.push_back({*ncc, *plane, {other, offset_px, *ncc}});
  }
}

}  // namespace

std::vector<int> ViewsToMatch(const StereoScene& scene, int view) {
  const auto axis = [&](int v) { return Eigen::Vector3d(scene.views[v].px_from_world.row(2).head<3>().normalized()); };
  // Cameras side by side have parallel axes; then the distance of their centres decides.
  std::vector<std::tuple<double, double, int>> by_angle;
  for (int other = 0; other < scene.NumViews(); ++other) {
    if (other == view) continue;
    const double distance = (scene.views[other].centre_in_world - scene.views[view].centre_in_world).norm();
    const double angle = std::acos(std::clamp(axis(view).dot(axis(other)), -1.0, 1.0));
    if (angle < kMaxAngleRad && distance > 0) by_angle.emplace_back(distance, angle, other);
  }
  std::sort(by_angle.begin(), by_angle.end());
  std::vector<int> views;
  for (const auto& [distance, angle, other] : by_angle) {
    if (views.size() < kMaxPartners) views.push_back(other);
  }
  return views;
}

std::optional<SurfacePatch> SeedPatch(const StereoScene& scene, const std::vector<std::vector<Feature>>& features,
                                      int view, const Feature& feature, const std::vector<int>& partners) {
  const std::optional<WindowTexture> texture =
      ReferenceTexture(scene, WindowPlane{view, feature.u_px, feature.v_px, Eigen::Vector3d::Zero()});
  if (!texture) return std::nullopt;
  std::vector<PairMatch> matches;
  for (const int other : partners) {
    MatchInView(scene, features[other], view, feature, other, *texture, matches);
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const PairMatch& a, const PairMatch& b) { return a.ncc > b.ncc; });
  if (matches.size() > kMaxTrials) matches.resize(kMaxTrials);
  std::optional<SurfacePatch> best;
  for (const PairMatch& match : matches) {
    std::vector<Sighting> hints;
    if (scene.free_offsets) hints.push_back(match.sighting);
    std::optional<SurfacePatch> patch = BuildPatch(scene, match.plane, hints);
    const auto support = [](const SurfacePatch& p) { return p.ncc * static_cast<float>(p.sightings.size()); };
    if (patch && (!best || support(*patch) > support(*best))) best = std::move(patch);
  }
  return best;
}

}  // namespace rigcal::stereo
