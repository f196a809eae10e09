#include "core/validate/align.h"

#include <ceres/tiny_solver.h>

#include <Eigen/Dense>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

namespace rigcal {
namespace {

constexpr double kMinDepth =
    1e-9;  ///< in the estimate's unit; nearer to the camera's plane counts as this (gt_error.py)

Projection ProjectRay(const Camera& camera, Eigen::Vector3d x_in_cam) {
  if (std::abs(x_in_cam.z()) < kMinDepth) x_in_cam.z() = kMinDepth;
  // A ray and its opposite have one pixel: only the derivative changes its sign.
  const double sign = x_in_cam.z() > 0 ? 1.0 : -1.0;
  Projection p = *ProjectWithJacobian(camera, sign * x_in_cam);
  p.by_point *= sign;
  return p;
}

/// The signed square root of soft-L1, so that least squares of it is soft-L1 of `r`: 2 c^2 (sqrt(1 + (r/c)^2) - 1).
double SoftL1Root(double r, double* by_r) {
  const double x = r / kAlignLossPx;
  const double root = std::sqrt(1 + x * x);
  const double slope = std::sqrt(2 / (root + 1));
  *by_r = 1 / (slope * root);
  return kAlignLossPx * x * slope;
}

/// Rows and columns of the scaled rotation q X q* of an unnormalised quaternion (w, x, y, z), and its derivatives.
Eigen::Matrix3d ScaledRotation(const Eigen::Vector4d& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Eigen::Matrix3d m;
  m << w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z;
  return m;
}

Eigen::Matrix<double, 3, 4> ScaledRotationByQuaternion(const Eigen::Vector4d& q, const Eigen::Vector3d& p) {
  // The matrix is a quadratic form of q: d/dq_k = M(q + e_k) - M(q) - M(e_k), the polar form.
  Eigen::Matrix<double, 3, 4> by_q;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector4d e = Eigen::Vector4d::Unit(k);
    by_q.col(k) = (ScaledRotation(q + e) - ScaledRotation(q) - ScaledRotation(e)) * p;
  }
  return by_q;
}

/// 7 parameters: unnormalised quaternion, translation in units of `unit_length`, both about `start`.
struct SimilarityModel {
  static constexpr int kNumParameters = 7;
  using Parameters = Eigen::Matrix<double, kNumParameters, 1>;
  Eigen::Matrix4d start;
  double unit_length = 1;

  [[nodiscard]] static Parameters Zero() {
    Parameters p = Parameters::Zero();
    p[0] = 1;
    return p;
  }
  [[nodiscard]] Eigen::Matrix4d Frame(const Parameters& p) const {
    Eigen::Matrix4d t = start;
    t.topLeftCorner<3, 3>() = ScaledRotation(p.head<4>()) * start.topLeftCorner<3, 3>();
    t.topRightCorner<3, 1>() += unit_length * p.tail<3>();
    return t;
  }
  [[nodiscard]] Eigen::Matrix<double, 4, kNumParameters> Derivative(const Parameters& p,
                                                                    const Eigen::Vector3d& x_in_unit) const {
    Eigen::Matrix<double, 4, kNumParameters> d = Eigen::Matrix<double, 4, kNumParameters>::Zero();
    d.topLeftCorner<3, 4>() = ScaledRotationByQuaternion(p.head<4>(), start.topLeftCorner<3, 3>() * x_in_unit);
    d.block<3, 3>(0, 4) = unit_length * Eigen::Matrix3d::Identity();
    return d;
  }
};

/// 15 parameters: row-major entries of E but the last one; frame = start * (I + E).
struct ProjectivityModel {
  static constexpr int kNumParameters = 15;
  using Parameters = Eigen::Matrix<double, kNumParameters, 1>;
  Eigen::Matrix4d start;

  [[nodiscard]] static Parameters Zero() { return Parameters::Zero(); }
  [[nodiscard]] Eigen::Matrix4d Frame(const Parameters& p) const {
    Eigen::Matrix4d e = Eigen::Matrix4d::Identity();
    for (int k = 0; k < kNumParameters; ++k) e(k / 4, k % 4) += p[k];
    return start * e;
  }
  [[nodiscard]] Eigen::Matrix<double, 4, kNumParameters> Derivative(const Parameters&,
                                                                    const Eigen::Vector3d& x_in_unit) const {
    const Eigen::Vector4d x = x_in_unit.homogeneous();
    Eigen::Matrix<double, 4, kNumParameters> d;
    for (int k = 0; k < kNumParameters; ++k) d.col(k) = start.col(k / 4) * x[k % 4];
    return d;
  }
};

template <typename Model>
struct AlignCost {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = Model::kNumParameters };
  const AlignProblem& problem;
  const Model& model;
  int num_residuals;

  AlignCost(const AlignProblem& of, const Model& with) : problem(of), model(with), num_residuals(0) {
    for (const AlignView& view : problem.views) num_residuals += 2 * static_cast<int>(view.points.size());
  }
  [[nodiscard]] int NumResiduals() const { return num_residuals; }

  bool operator()(const double* parameters, double* residuals, double* jacobian) const {
    const typename Model::Parameters p = Eigen::Map<const typename Model::Parameters>(parameters);
    const Eigen::Matrix4d frame = model.Frame(p);
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, NUM_PARAMETERS>> j(
        jacobian, jacobian == nullptr ? 0 : num_residuals, NUM_PARAMETERS);
    int row = 0;
    for (const AlignView& view : problem.views) {
      Eigen::Matrix<double, 3, 4> cam_from_estimate;
      cam_from_estimate << view.cam_from_world.rotation.toRotationMatrix(), view.cam_from_world.translation;
      for (std::size_t i = 0; i < view.points.size(); ++i, row += 2) {
        const Eigen::Vector3d& x_in_unit = problem.x_in_unit[view.points[i]];
        const Projection at = ProjectRay(view.camera, cam_from_estimate * (frame * x_in_unit.homogeneous()));
        Eigen::Vector2d by_r;
        for (int k = 0; k < 2; ++k) residuals[row + k] = SoftL1Root(at.x_px[k] - view.seen_px[i][k], &by_r[k]);
        if (jacobian == nullptr) continue;
        j.template middleRows<2>(row) =
            by_r.asDiagonal() * (at.by_point * cam_from_estimate * model.Derivative(p, x_in_unit));
      }
    }
    return true;
  }
};

template <typename Model>
AlignedFrame Solve(const AlignProblem& problem, const Model& model) {
  constexpr int kMaxIterations = 100;
  constexpr double kTolerance = 1e-12;  // far below the 0.001 px in which results are compared
  const AlignCost<Model> cost(problem, model);
  ceres::TinySolver<AlignCost<Model>> solver{};
  solver.options.max_num_iterations = kMaxIterations;
  solver.options.parameter_tolerance = kTolerance;
  solver.options.function_tolerance = kTolerance;
  typename Model::Parameters p = Model::Zero();
  const auto& summary = solver.Solve(cost, &p);
  return {model.Frame(p), summary.final_cost};
}

struct Similarity {
  double scale;
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
};

/// target ~ scale * rotation * source + translation with the rotation nearest to `correlation` (a sum of target
/// source^T, as in Umeyama 1991, or of rotations: the chordal mean, which works for centres on a line too).
Similarity SimilarityFrom(const Eigen::Matrix3d& correlation, const Eigen::Matrix3Xd& source,
                          const Eigen::Matrix3Xd& target) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Eigen::Matrix3d rotation = svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  const Eigen::Vector3d source_mean = source.rowwise().mean(), target_mean = target.rowwise().mean();
  const Eigen::Matrix3Xd turned = rotation * (source.colwise() - source_mean);
  const double scale = turned.cwiseProduct(target.colwise() - target_mean).sum() / turned.squaredNorm();
  return {scale, rotation, target_mean - scale * rotation * source_mean};
}

std::array<Similarity, 2> Starts(const AlignProblem& problem) {
  const auto num_views = static_cast<Eigen::Index>(problem.views.size());
  Eigen::Matrix3Xd source(3, num_views), target(3, num_views);
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < num_views; ++i) {
    const AlignView& view = problem.views[i];
    source.col(i) = CentreInWorld(view.reference_cam_from_world);
    target.col(i) = CentreInWorld(view.cam_from_world);
    rotations += (view.cam_from_world.rotation.conjugate() * view.reference_cam_from_world.rotation).toRotationMatrix();
  }
  const Eigen::Vector3d source_mean = source.rowwise().mean(), target_mean = target.rowwise().mean();
  const Eigen::Matrix3d centres = (target.colwise() - target_mean) * (source.colwise() - source_mean).transpose();
  return {SimilarityFrom(centres, source, target), SimilarityFrom(rotations, source, target)};
}

}  // namespace

std::vector<std::pair<int, int>> CommonViews(const RigCalibration& reference, const RigCalibration& estimate) {
  std::map<std::string_view, int> by_name;
  for (int j = 0; j < estimate.NumViews(); ++j) by_name.emplace(estimate.views[j].name, j);
  std::vector<std::pair<int, int>> common;
  for (int i = 0; i < reference.NumViews(); ++i) {
    if (const auto it = by_name.find(reference.views[i].name); it != by_name.end()) common.emplace_back(i, it->second);
  }
  return common;
}

AlignProblem MakeAlignProblem(const RigCalibration& reference, const RigCalibration& estimate,
                              const std::vector<ComparePoint>& points, const std::vector<std::pair<int, int>>& common) {
  AlignProblem problem;
  for (const ComparePoint& p : points) problem.mean_in_world += p.x_in_world / static_cast<double>(points.size());
  double sum = 0;
  for (const ComparePoint& p : points) sum += (p.x_in_world - problem.mean_in_world).squaredNorm();
  if (sum > 0) problem.scale = std::sqrt(sum / static_cast<double>(points.size()));
  for (const ComparePoint& p : points) {
    problem.x_in_unit.push_back((p.x_in_world - problem.mean_in_world) / problem.scale);
  }
  for (const auto& [i, j] : common) {
    AlignView view{estimate.CameraOf(j), estimate.views[j].cam_from_world, reference.views[i].cam_from_world, {}, {}};
    for (std::size_t k = 0; k < points.size(); ++k) {
      const std::vector<int>& seen_in = points[k].views;
      if (!seen_in.empty() && std::find(seen_in.begin(), seen_in.end(), i) == seen_in.end()) continue;
      const auto x_px = Project(reference.CameraOf(i), reference.views[i].cam_from_world * points[k].x_in_world);
      if (!x_px || !x_px->allFinite()) continue;
      view.points.push_back(static_cast<int>(k));
      view.seen_px.push_back(*x_px);
    }
    problem.views.push_back(std::move(view));
  }
  return problem;
}

Eigen::Vector2d ProjectAligned(const AlignView& view, const Eigen::Matrix4d& estimate_from_unit,
                               const Eigen::Vector3d& x_in_unit) {
  const Eigen::Vector4d x = estimate_from_unit * x_in_unit.homogeneous();
  return ProjectRay(view.camera, view.cam_from_world.rotation * x.head<3>() + view.cam_from_world.translation * x[3])
      .x_px;
}

AlignedFrame AlignBySimilarity(const AlignProblem& problem) {
  std::optional<AlignedFrame> best;
  for (Similarity start : Starts(problem)) {
    constexpr double kMinScale = 1e-9;  // a start only: mirrored or coinciding centres give none of their own
    if (!start.rotation.allFinite() || !std::isfinite(start.scale)) continue;
    start.scale = std::max(start.scale, kMinScale);
    SimilarityModel model;
    model.unit_length = start.scale * problem.scale;
    model.start = Eigen::Matrix4d::Identity();
    model.start.topLeftCorner<3, 3>() = model.unit_length * start.rotation;
    model.start.topRightCorner<3, 1>() = start.scale * start.rotation * problem.mean_in_world + start.translation;
    const AlignedFrame solved = Solve(problem, model);
    if (std::isfinite(solved.cost) && (!best || solved.cost < best->cost)) best = solved;
  }
  if (best) return *best;
  AlignedFrame as_it_is;
  as_it_is.estimate_from_unit.topLeftCorner<3, 3>() *= problem.scale;
  as_it_is.estimate_from_unit.topRightCorner<3, 1>() = problem.mean_in_world;
  return as_it_is;
}

AlignedFrame AlignByProjectivity(const AlignProblem& problem, const AlignedFrame& similarity) {
  const AlignedFrame solved = Solve(problem, ProjectivityModel{similarity.estimate_from_unit});
  return std::isfinite(solved.cost) ? solved : similarity;
}

}  // namespace rigcal
