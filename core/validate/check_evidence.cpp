#include <algorithm>
#include <numeric>

#include "core/validate/checks.h"
#include "core/validate/evidence.h"
#include "core/validate/limits.h"

namespace rigcal {

using namespace limits;

bool CheckFinite(JudgedCase* judged) {
  const RigCalibration& calibration = judged->input.calibration;
  for (int view = 0; view < calibration.NumViews(); ++view) {
    const Camera& camera = calibration.CameraOf(view);
    const Rigid3d& pose = calibration.views[view].cam_from_world;
    if (camera.Intrinsics().allFinite() && camera.fx_px > 0 && camera.fy_px > 0 && pose.rotation.coeffs().allFinite() &&
        pose.translation.allFinite()) {
      continue;
    }
    judged->Object(Verdict::kRejected, {"camera_is_finite", camera.fx_px, 0, "px", judged->NameOf(view), camera.id});
    return false;
  }
  return true;
}

void CheckSupport(JudgedCase* judged) {
  const auto num_tracks = static_cast<int>(judged->input.tracks.tracks.size());
  const auto num_judging = static_cast<int>(judged->judging_tracks.size());
  if (num_tracks < kMinTracks) {
    judged->Object(Verdict::kInconclusive, {"num_tracks", double(num_tracks), kMinTracks, "tracks", {}, {}});
  }
  if (num_judging < kMinHeldOutTracks) {
    judged->Object(Verdict::kInconclusive,
                   {"num_held_out_tracks", double(num_judging), kMinHeldOutTracks, "tracks", {}, {}});
  }
  for (int view = 0; view < judged->input.calibration.NumViews(); ++view) {
    const int count = judged->num_features[view];
    judged->report.views[view].num_features = count;
    if (count >= kMinFeaturesPerView) continue;
    judged->excluded[view] = true;
    judged->Object(Verdict::kInconclusive,
                   {"view_support", double(count), kMinFeaturesPerView, "features", judged->NameOf(view), {}});
  }
}

void CheckConnections(JudgedCase* judged) {
  const int num_views = judged->input.calibration.NumViews();
  const Eigen::MatrixXi shared = SharedTracks(judged->input.tracks.tracks, num_views);
  std::vector<int> group(num_views, -1);
  std::vector<std::vector<int>> groups;
  for (int first = 0; first < num_views; ++first) {
    if (group[first] >= 0 || judged->excluded[first]) continue;
    std::vector<int> members{first};
    group[first] = static_cast<int>(groups.size());
    for (std::size_t i = 0; i < members.size(); ++i) {
      for (int other = 0; other < num_views; ++other) {
        if (group[other] >= 0 || judged->excluded[other] || shared(members[i], other) < kMinSharedTracks) continue;
        group[other] = group[first];
        members.push_back(other);
      }
    }
    groups.push_back(members);
  }
  if (groups.size() < 2) return;
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  for (std::size_t g = 1; g < groups.size(); ++g) {
    int most = 0;  // tracks that its best view shares with any view of the largest group
    for (const int a : groups[g]) {
      for (const int b : groups[0]) most = std::max(most, shared(a, b));
    }
    judged->Object(
        Verdict::kInconclusive,
        {"view_connection", double(most), kMinSharedTracks, "shared tracks", judged->NameOf(groups[g].front()), {}});
  }
}

void CheckSharpness(JudgedCase* judged) {
  constexpr std::size_t kNumNeighbours = 4, kMinNeighbours = 2;
  const auto& sharpness = judged->input.sharpness;
  if (sharpness.empty()) return;
  const RigCalibration& calibration = judged->input.calibration;
  const std::vector<int> physical = PhysicalCameras(calibration);
  for (int view = 0; view < calibration.NumViews(); ++view) {
    std::vector<double> around;
    for (const int other : NeighboursOf(calibration, view)) {
      const bool same_camera = physical[calibration.views[other].camera] == physical[calibration.views[view].camera];
      if (same_camera && sharpness[other] > 0 && around.size() < kNumNeighbours) around.push_back(sharpness[other]);
    }
    if (around.size() < kMinNeighbours || !(sharpness[view] > 0)) continue;
    const double ratio = sharpness[view] / Median(around);
    if (ratio >= kMinSharpnessRatio) continue;
    judged->Object(Verdict::kInconclusive,
                   {"view_sharpness", ratio, kMinSharpnessRatio, "of its neighbours", judged->NameOf(view), {}});
  }
}

}  // namespace rigcal
