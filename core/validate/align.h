#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/rigid3.h"
#include "core/scene/rig_calibration.h"
#include "core/validate/compare.h"

namespace rigcal {

/// One view of an alignment: the estimate's camera, and where the reference sees which points.
struct AlignView {
  Camera camera;                         ///< of the estimate
  Rigid3d cam_from_world;                ///< of the estimate
  Rigid3d reference_cam_from_world;      ///< of the reference, for the start only
  std::vector<int> points;               ///< indices into AlignProblem::x_in_unit
  std::vector<Eigen::Vector2d> seen_px;  ///< of the reference, same length
};

/// min over T of sum rho(|project(estimate; T x) - seen|), rho the soft-L1 of each coordinate, kAlignLossPx wide.
struct AlignProblem {
  std::vector<Eigen::Vector3d> x_in_unit;  ///< the reference's points about their mean, scaled to an RMS norm of 1
  Eigen::Vector3d mean_in_world = Eigen::Vector3d::Zero();  ///< x_in_unit = (x_in_world - mean_in_world) / scale
  double scale = 1;
  std::vector<AlignView> views;
};

/// (view of the reference, view of the estimate), paired by name, in the reference's order.
std::vector<std::pair<int, int>> CommonViews(const RigCalibration& reference, const RigCalibration& estimate);

/// Points that a reference view does not see in front of it are left out there.
AlignProblem MakeAlignProblem(const RigCalibration& reference, const RigCalibration& estimate,
                              const std::vector<ComparePoint>& points, const std::vector<std::pair<int, int>>& common);

inline constexpr double kAlignLossPx = 2.0;  ///< where the loss turns linear (../shared/tools/gt_error.py, f_scale)

struct AlignedFrame {
  Eigen::Matrix4d estimate_from_unit = Eigen::Matrix4d::Identity();  ///< homogeneous
  double cost = 0;
};

/// Best of two starts: chordal mean of the rotations, and Umeyama's fit of the camera centres. `world` of `seen` is the
/// reference's, so the result contains the problem's mean and scale.
AlignedFrame AlignBySimilarity(const AlignProblem& problem);

/// Best projectivity, started at a similarity: similarity * (I + E), 15 free entries of E.
AlignedFrame AlignByProjectivity(const AlignProblem& problem, const AlignedFrame& similarity);

/// Pixel of a point given in the unit frame. Unlike Project it answers behind the camera too (as the same ray), and
/// next to its plane it gives a large finite pixel, so that a hopeless estimate can still be measured.
Eigen::Vector2d ProjectAligned(const AlignView& view, const Eigen::Matrix4d& estimate_from_unit,
                               const Eigen::Vector3d& x_in_unit);

}  // namespace rigcal
