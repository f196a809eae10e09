#include "core/rig/seed_anchors.h"

#include <algorithm>
#include <limits>

namespace rigcal {
namespace {

/// A view with fewer candidates than this many times its anchors takes them from all tracks.
constexpr int kCandidatesPerAnchor = 4;
/// Share of the candidates cut off at either end of the depths: the patches that lie far off the surface.
constexpr double kDepthTrim = 0.05;

struct Candidate {
  Eigen::Vector3d x_in_world;
  Eigen::Vector2d seed_px;
  double depth;
};

bool Observes(const Track& track, int view) {
  return std::any_of(track.observations.begin(), track.observations.end(),
                     [view](const Observation& o) { return o.view == view; });
}

std::vector<Candidate> CandidatesOf(const RigCalibration& seed, const TrackSet& tracks, int view, bool observed_only) {
  const Camera& camera = seed.CameraOf(view);
  std::vector<Candidate> candidates;
  for (const Track& track : tracks.tracks) {
    if (track.held_out || !track.x_in_world.allFinite() || (observed_only && !Observes(track, view))) continue;
    const Eigen::Vector3d x_in_cam = seed.views[view].cam_from_world * track.x_in_world;
    const std::optional<Eigen::Vector2d> x_px = Project(camera, x_in_cam);
    if (!x_px || !(x_px->minCoeff() >= 0) || !(x_px->x() < camera.width_px) || !(x_px->y() < camera.height_px))
      continue;
    candidates.push_back({track.x_in_world, *x_px, x_in_cam.z()});
  }
  return candidates;
}

void TrimDepths(std::vector<Candidate>& candidates) {
  if (candidates.empty()) return;
  std::vector<double> depths;
  for (const Candidate& c : candidates) depths.push_back(c.depth);
  std::sort(depths.begin(), depths.end());
  const auto cut = static_cast<std::size_t>(kDepthTrim * static_cast<double>(depths.size()));
  const double near = depths[cut], far = depths[depths.size() - 1 - cut];
  std::erase_if(candidates, [near, far](const Candidate& c) { return c.depth < near || c.depth > far; });
}

/// The candidate nearest to the middle of all, then always the one farthest from those taken (in the picture).
std::vector<Candidate> SpreadOut(const std::vector<Candidate>& candidates, int count) {
  std::vector<Candidate> taken;
  if (candidates.empty()) return taken;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Candidate& c : candidates) middle += c.seed_px / static_cast<double>(candidates.size());
  const auto nearer = [&middle](const Candidate& a, const Candidate& b) {
    return (a.seed_px - middle).squaredNorm() < (b.seed_px - middle).squaredNorm();
  };
  taken.push_back(*std::min_element(candidates.begin(), candidates.end(), nearer));
  std::vector<double> distance2(candidates.size(), std::numeric_limits<double>::infinity());
  while (static_cast<int>(taken.size()) < std::min(count, static_cast<int>(candidates.size()))) {
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      distance2[i] = std::min(distance2[i], (candidates[i].seed_px - taken.back().seed_px).squaredNorm());
    }
    taken.push_back(
        candidates[static_cast<std::size_t>(std::max_element(distance2.begin(), distance2.end()) - distance2.begin())]);
  }
  return taken;
}

}  // namespace

std::vector<SeedAnchor> ChooseSeedAnchors(const SeedPrior& prior, const TrackSet& tracks) {
  std::vector<SeedAnchor> anchors;
  for (int view = 0; view < prior.seed.NumViews(); ++view) {
    std::vector<Candidate> candidates = CandidatesOf(prior.seed, tracks, view, true);
    if (static_cast<int>(candidates.size()) < kCandidatesPerAnchor * prior.points_per_view) {
      candidates = CandidatesOf(prior.seed, tracks, view, false);
    }
    TrimDepths(candidates);
    for (const Candidate& c : SpreadOut(candidates, prior.points_per_view)) {
      anchors.push_back({view, c.x_in_world, c.seed_px});
    }
  }
  return anchors;
}

}  // namespace rigcal
