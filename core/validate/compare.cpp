#include "core/validate/compare.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/validate/align.h"

namespace rigcal {
namespace {

/// Linear between the two neighbours in order, like numpy.percentile. `sorted` is not empty.
double Percentile(const std::vector<double>& sorted, double percent) {
  const double at = percent / 100 * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (at - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

void FillDistances(const AlignProblem& problem, const Eigen::Matrix4d& estimate_from_unit, CompareReport* report) {
  constexpr double kMedianPercent = 50, kHighPercent = 95;
  std::vector<double> all;
  double sum = 0, sum2 = 0;
  for (const AlignView& view : problem.views) {
    double view_sum = 0;
    for (std::size_t i = 0; i < view.points.size(); ++i) {
      const Eigen::Vector2d x_px = ProjectAligned(view, estimate_from_unit, problem.x_in_unit[view.points[i]]);
      all.push_back((x_px - view.seen_px[i]).norm());
      view_sum += all.back();
      sum2 += all.back() * all.back();
    }
    report->view_mean_px.push_back(view.points.empty() ? 0.0 : view_sum / static_cast<double>(view.points.size()));
    sum += view_sum;
  }
  const auto n = static_cast<double>(all.size());
  std::sort(all.begin(), all.end());
  report->mean_px = sum / n;
  report->rms_px = std::sqrt(sum2 / n);
  report->median_px = Percentile(all, kMedianPercent);
  report->p95_px = Percentile(all, kHighPercent);
  report->max_px = all.back();
}

Eigen::Vector3d MedianPoint(const std::vector<ComparePoint>& points) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> v;
    for (const ComparePoint& p : points) v.push_back(p.x_in_world[axis]);
    std::sort(v.begin(), v.end());
    median[axis] = Percentile(v, 50);
  }
  return median;
}

/// Rotation, centre and focal length: what only a similarity leaves comparable.
void FillParameters(const RigCalibration& reference, const RigCalibration& estimate,
                    const std::vector<std::pair<int, int>>& common, const AlignProblem& problem,
                    const Eigen::Matrix4d& estimate_from_unit, const Eigen::Vector3d& object_in_world,
                    CompareReport* report) {
  const Eigen::Matrix3d scaled = estimate_from_unit.topLeftCorner<3, 3>();
  const double unit_scale = std::cbrt(scaled.determinant());
  const Eigen::Matrix3d rotation = scaled / unit_scale;
  const double scale = unit_scale / problem.scale;
  const Eigen::Vector3d shift = estimate_from_unit.topRightCorner<3, 1>() - scale * rotation * problem.mean_in_world;
  const auto n = static_cast<double>(common.size());
  for (const auto& [i, j] : common) {
    const Rigid3d& ref = reference.views[i].cam_from_world;
    const Rigid3d& est = estimate.views[j].cam_from_world;
    const Eigen::Vector3d centre = CentreInWorld(ref);
    const Eigen::Vector3d moved = rotation.transpose() * (CentreInWorld(est) - shift) / scale;
    report->centre_relative += (moved - centre).norm() / (centre - object_in_world).norm() / n;
    const Eigen::Quaterniond turn = est.rotation * Eigen::Quaterniond(rotation) * ref.rotation.conjugate();
    const double angle_deg = LogRotation(turn.normalized()).norm() * 180 / std::numbers::pi;
    report->rotation_mean_deg += angle_deg / n;
    report->rotation_max_deg = std::max(report->rotation_max_deg, angle_deg);
    const Camera &a = reference.CameraOf(i), &b = estimate.CameraOf(j);
    report->focal_relative += (std::abs(b.fx_px / a.fx_px - 1) + std::abs(b.fy_px / a.fy_px - 1)) / (2 * n);
  }
}

}  // namespace

Result<CompareReport> CompareCameras(const RigCalibration& reference, const RigCalibration& estimate,
                                     const std::vector<ComparePoint>& points, CompareAlignment alignment) {
  constexpr std::size_t kMinViews = 2;
  const auto common = CommonViews(reference, estimate);
  if (common.size() < kMinViews) {
    return Fail(ErrorCode::kBadInput, "comparison: {} views of the same name in both calibrations, needs at least {}",
                common.size(), kMinViews);
  }
  const AlignProblem problem = MakeAlignProblem(reference, estimate, points, common);
  std::size_t num_seen = 0;
  for (const AlignView& view : problem.views) num_seen += view.points.size();
  constexpr std::size_t kMinSeen = 8;  // 16 coordinates: more than the 15 parameters of a projectivity
  if (num_seen < kMinSeen) {
    return Fail(ErrorCode::kBadInput,
                "comparison: {} projections of {} points into the common views, needs at least {}", num_seen,
                points.size(), kMinSeen);
  }
  AlignedFrame frame = AlignBySimilarity(problem);
  CompareReport report;
  report.num_views = static_cast<int>(common.size());
  if (alignment == CompareAlignment::kProjectivity) {
    frame = AlignByProjectivity(problem, frame);
  } else {
    FillParameters(reference, estimate, common, problem, frame.estimate_from_unit, MedianPoint(points), &report);
  }
  FillDistances(problem, frame.estimate_from_unit, &report);
  return report;
}

}  // namespace rigcal
