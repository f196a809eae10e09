#include <Eigen/Dense>
#include <algorithm>

#include "core/validate/checks.h"
#include "core/validate/evidence.h"
#include "core/validate/limits.h"

namespace rigcal {
namespace {

using namespace limits;

constexpr std::size_t kMinValues = 5;  ///< a mean of fewer residuals says nothing about a view or a kind of pair

/// Robust mean residual of each view; 0 where there are too few.
std::vector<double> ViewMeans(const std::vector<CrossResidual>& residuals, int num_views) {
  std::vector<std::vector<double>> of_view(num_views);
  for (const CrossResidual& r : residuals) of_view[r.view].push_back(r.residual_px);
  std::vector<double> means;
  for (const auto& values : of_view) means.push_back(values.size() < kMinValues ? 0.0 : RobustMean(values));
  return means;
}

double MeanOf(const std::vector<CrossResidual>& residuals) {
  std::vector<double> values;
  for (const CrossResidual& r : residuals) values.push_back(r.residual_px);
  return RobustMean(values);
}

/// Symmetric point-to-line distances of one pair of views.
class Epipolar {
 public:
  Epipolar(const RigCalibration& calibration, int a, int b) {
    const Rigid3d b_from_a = calibration.views[b].cam_from_world * calibration.views[a].cam_from_world.Inverse();
    f_ = calibration.CameraOf(b).CalibrationMatrix().inverse().transpose() * Skew(b_from_a.translation) *
         b_from_a.rotation.toRotationMatrix() * calibration.CameraOf(a).CalibrationMatrix().inverse();
  }
  [[nodiscard]] double Distance(const Eigen::Vector2d& in_a, const Eigen::Vector2d& in_b) const {
    const Eigen::Vector3d line_b = f_ * in_a.homogeneous(), line_a = f_.transpose() * in_b.homogeneous();
    const double n = std::abs(in_b.homogeneous().dot(line_b));
    return 0.5 * (n / line_b.head<2>().norm() + n / line_a.head<2>().norm());
  }

 private:
  Eigen::Matrix3d f_;
};

/// near(a, b): b is one of the two nearest views of a (or the reverse) among those that share tracks with it.
Eigen::MatrixXi NearPairs(const RigCalibration& calibration, const std::vector<Track>& tracks) {
  constexpr int kNearest = 2;
  const int num_views = calibration.NumViews();
  const Eigen::MatrixXi shared = SharedTracks(tracks, num_views);
  Eigen::MatrixXi near = Eigen::MatrixXi::Zero(num_views, num_views);
  for (int a = 0; a < num_views; ++a) {
    int found = 0;
    for (const int b : NeighboursOf(calibration, a)) {
      if (found == kNearest) break;
      if (shared(a, b) == 0) continue;
      near(a, b) = near(b, a) = 1;
      ++found;
    }
  }
  return near;
}

}  // namespace

void CheckViewResiduals(JudgedCase* judged) {
  // Held-out features alone are too few for a single view: one of 12 features with two outliers looked wrong.
  constexpr int kFeaturesPerView = 150;
  const RigCalibration& calibration = judged->input.calibration;
  const int num_views = calibration.NumViews();
  const auto tracks = SpreadSubset(judged->input.tracks, num_views, kFeaturesPerView);
  for (int taken_out = 0; 2 * taken_out <= num_views; ++taken_out) {
    const auto means = ViewMeans(CrossResiduals(calibration, tracks, judged->excluded), num_views);
    for (int view = 0; view < num_views; ++view) {
      // What a view is reported with: as found with all views that were still in when it was judged.
      if (!judged->excluded[view]) judged->report.views[view].residual_px = means[view];
    }
    std::vector<double> judged_means;
    for (const double mean : means) {
      if (mean > 0) judged_means.push_back(mean);
    }
    const int worst = static_cast<int>(std::max_element(means.begin(), means.end()) - means.begin());
    const double limit = std::max(kMinViewResidualPx, kMaxViewResidualRatio * Median(judged_means));
    if (judged_means.empty() || means[worst] <= limit) return;
    // A wrong view spoils its neighbours' points: the next round judges the others without it.
    judged->excluded[worst] = true;
    judged->Object(Verdict::kRejected, {"view_residual", means[worst], limit, "px", judged->NameOf(worst), {}});
  }
}

void CheckHoldout(JudgedCase* judged) {
  HoldoutError& holdout = judged->report.holdout;
  const ValidationInput& input = judged->input;
  holdout.num_tracks = static_cast<int>(judged->judging_tracks.size());
  holdout.after_px = MeanOf(CrossResiduals(input.calibration, judged->judging_tracks, judged->excluded));
  if (holdout.after_px > kMaxHoldoutPx) {
    judged->Object(Verdict::kRejected, {"holdout_error", holdout.after_px, kMaxHoldoutPx, "px", {}, {}});
  }
  if (!input.prior) return;
  holdout.before_px = MeanOf(CrossResiduals(*input.prior, judged->judging_tracks, judged->excluded));
  const double limit = kMaxHoldoutGrowth * *holdout.before_px + kMaxHoldoutGrowthPx;
  if (holdout.after_px > limit) {
    judged->Object(Verdict::kRejected, {"holdout_error_against_before", holdout.after_px, limit, "px", {}, {}});
  }
}

void CheckEpipolar(JudgedCase* judged) {
  const RigCalibration& calibration = judged->input.calibration;
  const Eigen::MatrixXi near = NearPairs(calibration, judged->judging_tracks);
  std::vector<std::vector<std::optional<Epipolar>>> pairs(
      calibration.views.size(), std::vector<std::optional<Epipolar>>(calibration.views.size()));
  std::vector<double> distances[2];  // far, near
  for (const Track& track : judged->judging_tracks) {
    for (const Observation& a : track.observations) {
      for (const Observation& b : track.observations) {
        if (a.view >= b.view || judged->excluded[a.view] || judged->excluded[b.view]) continue;
        const auto in_a = UndistortedPx(calibration.CameraOf(a.view), a.x_px);
        const auto in_b = UndistortedPx(calibration.CameraOf(b.view), b.x_px);
        if (!in_a || !in_b) continue;
        auto& pair = pairs[a.view][b.view];
        if (!pair) pair.emplace(calibration, a.view, b.view);
        const double distance = pair->Distance(*in_a, *in_b);
        if (std::isfinite(distance)) distances[near(a.view, b.view)].push_back(distance);
      }
    }
  }
  for (const int is_near : {1, 0}) {
    if (distances[is_near].size() < kMinValues) continue;
    const double mean = RobustMean(distances[is_near]);
    if (mean <= kMaxEpipolarPx) continue;
    judged->Object(Verdict::kRejected,
                   {is_near == 1 ? "epipolar_error_near" : "epipolar_error_far", mean, kMaxEpipolarPx, "px", {}, {}});
  }
}

}  // namespace rigcal
