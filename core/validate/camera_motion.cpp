#include "core/validate/camera_motion.h"

#include <algorithm>
#include <cmath>

#include "core/rig/poses_by_rig.h"
#include "core/rig/projection_uncertainty.h"
#include "core/rig/rig_model_pose.h"
#include "core/validate/compare.h"
#include "core/validate/view_motion.h"

namespace rigcal {
namespace {

/// Object points of each view that its sigma is taken over, as the verdict does (check_priors.cpp).
constexpr std::size_t kSigmaPointsPerView = 50;

bool SameKindOfRig(const RigCalibration& before, const RigCalibration& after) {
  if (!before.rig || !after.rig) return false;
  const Positioner &a = before.rig->model.positioner, &b = after.rig->model.positioner;
  return a.kind == b.kind && a.load == b.load && a.num_axes == b.num_axes;
}

std::optional<int> CameraNamed(const RigCalibration& calibration, const std::string& id) {
  const auto found = std::ranges::find(calibration.cameras, id, &Camera::id);
  if (found == calibration.cameras.end()) return std::nullopt;
  return static_cast<int>(found - calibration.cameras.begin());
}

/// The cameras of a rig at exact stops.
struct Placed {
  RigCalibration calibration;
  std::vector<int> stop_of_view;
};

Placed WithoutViews(const RigCalibration& calibration) {
  Placed placed{.calibration = calibration};
  placed.calibration.views.clear();
  placed.calibration.covariance.reset();
  return placed;
}

void Place(const std::vector<StopPosition>& stops, Placed& placed) {
  const RigEstimate& rig = *placed.calibration.rig;
  const std::vector<StopError> exact(stops.size(), StopError::Zero());
  PlaceViews(rig.model, stops, exact, placed.stop_of_view, placed.calibration);
  placed.calibration.covariance = CovarianceByRig(rig, stops, placed.stop_of_view, placed.calibration);
}

/// Both at the stops of before's views, the cameras that have a place in both rigs.
void PlaceBoth(RigCalibration& before, RigCalibration& after) {
  Placed was = WithoutViews(before), is = WithoutViews(after);
  std::vector<StopPosition> stops;
  for (const View& view : before.views) {
    const auto& mount = before.rig->model.cam_from_mount[view.camera];
    const auto camera_after = CameraNamed(after, before.cameras[view.camera].id);
    if (!mount || !camera_after || !after.rig->model.cam_from_mount[*camera_after]) continue;
    const int stop = static_cast<int>(stops.size());
    stops.push_back(StopAt(before.rig->model.positioner, *mount, view.cam_from_world));
    was.calibration.views.push_back({view.name, view.camera, {}});
    is.calibration.views.push_back({view.name, *camera_after, {}});
    was.stop_of_view.push_back(stop);
    is.stop_of_view.push_back(stop);
  }
  Place(stops, was);
  Place(stops, is);
  before = std::move(was.calibration);
  after = std::move(is.calibration);
}

/// Stated sigma of each view at the object, on points of the calibration's own frame. Nothing: none is stated.
std::optional<std::vector<double>> StatedSigmaPx(const RigCalibration& calibration) {
  if (!calibration.covariance) return std::nullopt;
  const auto points = SpreadPoints(calibration);
  if (!points) return std::nullopt;
  std::vector<std::vector<const ComparePoint*>> seen(calibration.views.size());
  for (const ComparePoint& point : *points) {
    for (const int view : point.views) seen[view].push_back(&point);
  }
  std::vector<ViewPoint> of_views;
  for (int view = 0; view < calibration.NumViews(); ++view) {
    const std::size_t step = 1 + seen[view].size() / kSigmaPointsPerView;
    for (std::size_t i = 0; i < seen[view].size(); i += step) of_views.push_back({view, seen[view][i]->x_in_world});
  }
  return ProjectionSigmaPx(calibration, of_views);
}

/// Physical cameras of `one` that `other` does not have.
std::vector<std::string> OnlyIn(const RigCalibration& one, const RigCalibration& other) {
  std::vector<std::string> only;
  for (const Camera& camera : one.cameras) {
    const bool in_other =
        std::ranges::find(other.cameras, camera.physical_id, &Camera::physical_id) != other.cameras.end();
    const bool named = std::ranges::find(only, camera.physical_id) != only.end();
    if (!in_other && !named) only.push_back(camera.physical_id);
  }
  return only;
}

/// Sums over a camera's views, made means at the end.
struct MotionSum {
  CameraMotion motion;
  double variance_px2 = 0;
};

CameraMotion MeanOf(MotionSum sum, bool has_sigma) {
  const double n = sum.motion.num_views;
  sum.motion.moved_px /= n;
  sum.motion.shift_px /= n;
  if (sum.motion.shift_px.norm() > 0) sum.motion.direction = sum.motion.shift_px.normalized();
  if (has_sigma) sum.motion.sigma_px = std::sqrt(sum.variance_px2 / n);
  return sum.motion;
}

std::vector<CameraMotion> PerCamera(const RigCalibration& before, const RigCalibration& after,
                                    const std::vector<ViewMotion>& motions) {
  const auto sigma_before = StatedSigmaPx(before), sigma_after = StatedSigmaPx(after);
  const bool has_sigma = sigma_before && sigma_after;
  std::vector<MotionSum> sums;
  for (const ViewMotion& moved : motions) {
    const std::string& camera = before.CameraOf(moved.reference_view).physical_id;
    auto sum = std::ranges::find_if(sums, [&](const MotionSum& s) { return s.motion.camera == camera; });
    if (sum == sums.end()) sum = sums.insert(sums.end(), MotionSum{.motion = {.camera = camera}});
    ++sum->motion.num_views;
    sum->motion.moved_px += moved.moved_px;
    sum->motion.shift_px += moved.shift_px;
    if (!has_sigma) continue;
    const double a = (*sigma_before)[moved.reference_view], b = (*sigma_after)[moved.estimate_view];
    sum->variance_px2 += a * a + b * b;
  }
  std::vector<CameraMotion> cameras;
  for (const MotionSum& sum : sums) cameras.push_back(MeanOf(sum, has_sigma));
  return cameras;
}

}  // namespace

Result<CalibrationDifference> CompareCalibrations(const RigCalibration& before, const RigCalibration& after) {
  CalibrationDifference difference{.by_rig = SameKindOfRig(before, after),
                                   .only_before = OnlyIn(before, after),
                                   .only_after = OnlyIn(after, before)};
  RigCalibration was = before, is = after;
  if (difference.by_rig) PlaceBoth(was, is);
  const auto points = SpreadPoints(was);
  if (!points) return Fail(points.error());
  const std::vector<ViewMotion> motions = ViewMotions(was, is, *points);
  if (motions.size() < 2) {
    return Fail(ErrorCode::kBadInput,
                "comparison: {} views to compare, at least 2 are needed; calibrations of a rig are compared by their "
                "cameras' ids, others by the names of their views",
                motions.size());
  }
  for (const ViewMotion& moved : motions) difference.mean_px += moved.moved_px / static_cast<double>(motions.size());
  difference.num_views = static_cast<int>(motions.size());
  difference.cameras = PerCamera(was, is, motions);
  return difference;
}

}  // namespace rigcal
