#include "core/validate/view_motion.h"

#include "core/validate/align.h"

namespace rigcal {

std::vector<ViewMotion> ViewMotions(const RigCalibration& reference, const RigCalibration& estimate,
                                    const std::vector<ComparePoint>& points) {
  std::vector<ViewMotion> motions;
  const auto common = CommonViews(reference, estimate);
  if (points.empty() || common.size() < 2) return motions;
  const AlignProblem problem = MakeAlignProblem(reference, estimate, points, common);
  const Eigen::Matrix4d estimate_from_unit = AlignBySimilarity(problem).estimate_from_unit;
  for (std::size_t c = 0; c < common.size(); ++c) {
    const AlignView& view = problem.views[c];
    if (view.points.empty()) continue;
    ViewMotion motion{.reference_view = common[c].first, .estimate_view = common[c].second};
    const auto n = static_cast<double>(view.points.size());
    for (std::size_t i = 0; i < view.points.size(); ++i) {
      const Eigen::Vector2d moved_px =
          ProjectAligned(view, estimate_from_unit, problem.x_in_unit[view.points[i]]) - view.seen_px[i];
      motion.moved_px += moved_px.norm() / n;
      motion.shift_px += moved_px / n;
    }
    motions.push_back(motion);
  }
  return motions;
}

}  // namespace rigcal
