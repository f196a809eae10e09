#include "core/drift/picture_motion.h"

#include <Eigen/QR>
#include <cmath>

#include "core/rig/reprojection.h"
#include "core/rig/rig_model_pose.h"

namespace rigcal {
namespace {

constexpr int kSimilaritySize = 7;  ///< rotation, translation, scale
using SimilarityRows = std::vector<Eigen::Matrix<double, 2, kSimilaritySize>>;

/// How x' = x + w x x + t + s x moves a point.
Eigen::Matrix<double, 3, kSimilaritySize> BySimilarity(const Eigen::Vector3d& x_in_world) {
  Eigen::Matrix<double, 3, kSimilaritySize> by;
  by << -Skew(x_in_world), Eigen::Matrix3d::Identity(), x_in_world;
  return by;
}

/// The rows of a camera; `by_object`, when asked for, how the same pictures follow a similarity of the object.
PictureRows RowsOf(const DriftInput& input, int camera, SimilarityRows* by_object) {
  PictureRows rows;
  const RigModel& model = input.in_force.model;
  for (const ViewPoint& point : input.points) {
    const View& view = input.placed.views[point.view];
    if (view.camera != camera) continue;
    const auto seen = Reproject(input.placed.cameras[camera], view.cam_from_world, point.x_in_world);
    if (!seen) continue;
    const StopPosition& stop = input.stops[input.stop_of_view[point.view]];
    const RigPose pose = RigPoseAt(model.positioner, *model.cam_from_mount[camera], stop, StopError::Zero());
    rows.emplace_back(seen->by_pose * pose.by_mount);
    if (by_object != nullptr) by_object->emplace_back(seen->by_point * BySimilarity(point.x_in_world));
  }
  return rows;
}

/// What is left of the rows beside every similarity of the object.
void TakeSimilarityOut(const SimilarityRows& by_object, PictureRows& rows) {
  if (rows.empty()) return;
  const auto count = static_cast<Eigen::Index>(2 * rows.size());
  Eigen::MatrixXd motion(count, kMotionSize), object(count, kSimilaritySize);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    motion.middleRows<2>(2 * static_cast<Eigen::Index>(i)) = rows[i];
    object.middleRows<2>(2 * static_cast<Eigen::Index>(i)) = by_object[i];
  }
  motion -= object * object.completeOrthogonalDecomposition().solve(motion);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = motion.middleRows<2>(2 * static_cast<Eigen::Index>(i));
}

}  // namespace

PictureRows RowsOfCamera(const DriftInput& input, int camera) {
  return RowsOf(input, camera, nullptr);
}

PictureRows RowsOfLoneCamera(const DriftInput& input, int camera) {
  SimilarityRows by_object;
  PictureRows rows = RowsOf(input, camera, &by_object);
  TakeSimilarityOut(by_object, rows);
  return rows;
}

PictureRows RowsOfAll(const DriftInput& input) {
  SimilarityRows by_object;
  PictureRows all;
  for (int c = 0; c < static_cast<int>(input.in_force.cameras.size()); ++c) {
    const auto& mount = input.in_force.model.cam_from_mount[c];
    if (!mount) continue;
    for (const auto& row : RowsOf(input, c, &by_object)) all.emplace_back(row * DisturbanceThrough(*mount));
  }
  TakeSimilarityOut(by_object, all);
  return all;
}

PictureMotion MotionOf(const PictureRows& rows, const MotionVector& motion, const MotionMatrix& covariance) {
  PictureMotion out;
  if (rows.empty()) return out;
  const auto n = static_cast<double>(rows.size());
  Eigen::Matrix<double, 2, kMotionSize> mean = Eigen::Matrix<double, 2, kMotionSize>::Zero();
  double variance_px2 = 0;
  for (const auto& row : rows) {
    out.moved_px += (row * motion).norm() / n;
    variance_px2 += (row * covariance * row.transpose()).trace() / n;
    mean += row / n;
  }
  out.sigma_px = std::sqrt(std::max(0.0, variance_px2));
  out.shift_px = mean * motion;
  out.shift_sigma_px = (mean * covariance * mean.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  return out;
}

}  // namespace rigcal
