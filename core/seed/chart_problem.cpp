#include "core/seed/chart_problem.h"

#include <ceres/normal_prior.h>

#include <algorithm>
#include <cmath>

#include "core/rig/camera_information.h"
#include "core/rig/solver.h"
#include "core/seed/chart_residuals.h"

namespace rigcal {
namespace {

constexpr int kMaxIterations = 100;
/// Relative decrease of the cost at which the solution counts as found: 1e-10 of some 10^4 squared sigmas is far below
/// what moves any parameter by a hundredth of its sigma.
constexpr double kFunctionTolerance = 1e-10;
constexpr double kExactScale = 1e-9;  ///< stands for an axis_scale_sigma of 0: a nanometre in a metre

Eigen::Matrix2d WhiteningOf(const ChartCorner& corner, double scale) {
  const Eigen::Matrix2d lower = corner.covariance_px2.llt().matrixL();
  return lower.inverse() / scale;
}

std::unique_ptr<ceres::LossFunction> CornerLoss(const ChartLosses& losses) {
  if (losses.corner_cauchy > 0) return std::make_unique<ceres::CauchyLoss>(losses.corner_cauchy);
  if (losses.corner_huber > 0) return std::make_unique<ceres::HuberLoss>(losses.corner_huber);
  return nullptr;
}

void AddNormalEquations(const ceres::CRSMatrix& jacobian, int count, ChartLinearisation& out) {
  out.information = Eigen::MatrixXd::Zero(count, count);
  out.gradient = Eigen::VectorXd::Zero(count);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    for (int a = jacobian.rows[row]; a < jacobian.rows[row + 1]; ++a) {
      const double weighted = out.row_weight[row] * jacobian.values[a];
      out.gradient[jacobian.cols[a]] += weighted * out.residuals[row];
      for (int b = jacobian.rows[row]; b < jacobian.rows[row + 1]; ++b) {
        out.information(jacobian.cols[a], jacobian.cols[b]) += weighted * jacobian.values[b];
      }
    }
  }
}

/// Per camera: sum over its rows of 1 - w j C j^T.
std::vector<double> DegreesOfFreedom(const ChartTerms& terms, const ceres::CRSMatrix& jacobian,
                                     const ChartLinearisation& fit) {
  std::vector<double> sum(terms.noise_scale.size(), 0.0);
  for (std::size_t v = 0; v < terms.views.size(); ++v) {
    const ChartView& view = terms.views[v];
    const int first = fit.row_of_view[v];
    for (int row = first; row < first + 2 * static_cast<int>(view.corners.size()); ++row) {
      double leverage = 0;
      for (int a = jacobian.rows[row]; a < jacobian.rows[row + 1]; ++a) {
        for (int b = jacobian.rows[row]; b < jacobian.rows[row + 1]; ++b) {
          leverage += jacobian.values[a] * fit.covariance(jacobian.cols[a], jacobian.cols[b]) * jacobian.values[b];
        }
      }
      sum[view.camera] += 1 - fit.row_weight[row] * leverage;
    }
  }
  return sum;
}

}  // namespace

/// The unknowns as Ceres sees them. Each kind lies in one array: Ceres orders blocks by address, and the order decides
/// the rounding.
struct ChartProblem::Blocks {
  Blocks(const ChartTerms& terms_in, const ChartLosses& losses, const ChartState& state)
      : terms(terms_in),
        corner_loss(CornerLoss(losses)),
        stop_loss(losses.stop_error_cauchy > 0 ? std::make_unique<ceres::CauchyLoss>(losses.stop_error_cauchy)
                                               : nullptr),
        problem(SharingProblemOptions()) {
    Load(state);
    for (int v = 0; v < static_cast<int>(terms.views.size()); ++v) AddCorners(v, state.rig.positioner);
    num_corner_blocks = residuals.size();
    AddPriors(state.rig);
    ListColumns(state.rig.positioner);
  }

  void Load(const ChartState& state) {
    for (const Camera& camera : state.cameras)
      IntrinsicVector::Map(intrinsics.emplace_back().data()) = camera.Intrinsics();
    for (const auto& mount : state.rig.cam_from_mount) mounts.push_back(PoseBlockOf(mount.value_or(Rigid3d{})));
    for (const StopError& error : state.stop_errors) StopError::Map(stop_errors.emplace_back().data()) = error;
    for (const Rigid3d& pose : state.cam_from_board) poses.push_back(PoseBlockOf(pose));
    shape = BlockOf(state.shape);
    place = state.place;
    anchor = PoseBlockOf(state.rig.positioner.anchor_from_world);
    Eigen::Matrix3d::Map(axes.data()) = state.rig.positioner.axes_in_stage;
    rig_views.reserve(terms.views.size());
  }

  void AddCorners(int v, const Positioner& positioner) {
    const ChartView& view = terms.views[v];
    rig_views.push_back({positioner, view.stop ? terms.stops[*view.stop] : StopPosition{}});
    row_of_view.push_back(2 * static_cast<int>(residuals.size()));
    for (const ChartCorner& corner : view.corners) {
      const WhitenedCorner whitened{corner.tag_id, corner.corner, corner.x_px,
                                    WhiteningOf(corner, terms.noise_scale[view.camera])};
      double* k = intrinsics[view.camera].data();
      if (view.stop) {
        residuals.push_back(problem.AddResidualBlock(new TableCornerResidual(terms.board, rig_views[v], whitened),
                                                     corner_loss.get(), k, mounts[view.camera].data(),
                                                     stop_errors[*view.stop].data(), anchor.data(), axes.data(),
                                                     place.data(), shape.data()));
      } else {
        residuals.push_back(problem.AddResidualBlock(new HandHeldCornerResidual(terms.board, whitened),
                                                     corner_loss.get(), k, poses[v].data(), shape.data()));
      }
    }
  }

  void AddPriors(const RigModel& rig) {
    const Eigen::Vector3d shape_weight(1 / terms.bow_sigma_m, 1 / terms.bow_sigma_m, 1 / terms.stretch_sigma);
    AddPrior(shape_weight.asDiagonal(), Eigen::Vector3d::Zero(), nullptr, shape.data());
    for (std::size_t s = 0; s < stop_errors.size(); ++s) {
      const StopError weight =
          terms.stop_error_sigma[s].unaryExpr([](double sigma) { return sigma > 0 ? 1 / sigma : 0.0; });
      AddPrior(weight.asDiagonal(), StopError::Zero(), stop_loss.get(), stop_errors[s].data());
    }
    for (int k = 0; k < rig.positioner.num_axes; ++k) {  // length 1: to first order, the component along the axis
      const Eigen::Vector3d along = rig.positioner.axes_in_stage.col(k).normalized();
      Eigen::MatrixXd row = Eigen::MatrixXd::Zero(1, kAxesBlockSize);
      row.block<1, 3>(0, 3 * k) = along.transpose() / std::max(rig.axis_scale_sigma, kExactScale);
      Eigen::VectorXd unit = Eigen::VectorXd::Zero(kAxesBlockSize);
      unit.segment<3>(3 * k) = along;
      AddPrior(row, unit, nullptr, axes.data());
    }
  }

  void AddPrior(const Eigen::MatrixXd& weight, const Eigen::VectorXd& mean, ceres::LossFunction* loss, double* block) {
    residuals.push_back(problem.AddResidualBlock(new ceres::NormalPrior(weight, mean), loss, block));
  }

  /// Gives a block its manifold with `held` components fixed, and the rest columns; all -1 when it is not in use.
  template <std::size_t kSize>
  std::array<int, kSize> Place(double* block, const std::vector<int>& held) {
    std::array<int, kSize> at;
    at.fill(-1);
    if (!problem.HasParameterBlock(block)) return at;
    if (held.size() == kSize) {
      problem.SetParameterBlockConstant(block);
      return at;
    }
    if (!held.empty()) {
      subsets.push_back(std::make_unique<ceres::SubsetManifold>(static_cast<int>(kSize), held));
      problem.SetManifold(block, subsets.back().get());
    }
    free_blocks.push_back(block);
    for (int k = 0; k < static_cast<int>(kSize); ++k) {
      if (std::find(held.begin(), held.end(), k) == held.end()) at[k] = columns.count++;
    }
    return at;
  }

  int PlacePose(PoseBlock& block) {
    if (!problem.HasParameterBlock(block.data())) return -1;
    problem.SetManifold(block.data(), &pose_manifold);
    free_blocks.push_back(block.data());
    columns.count += 6;
    return columns.count - 6;
  }

  void ListColumns(const Positioner& positioner) {
    for (std::size_t c = 0; c < intrinsics.size(); ++c) {
      std::vector<int> held = {kSkew};
      if (!terms.uses_k3[c]) held.push_back(kK3);
      columns.intrinsics.push_back(Place<kNumIntrinsics>(intrinsics[c].data(), held));
    }
    columns.shape = Place<kBoardShapeSize>(shape.data(), {})[0];
    const bool turntable = positioner.kind == PositionerKind::kTurntable;
    columns.place = Place<kBoardPlaceSize>(place.data(), turntable ? std::vector<int>{} : std::vector{0, 1, 2, 3})[0];
    if (positioner.kind == PositionerKind::kArm) {
      columns.anchor = PlacePose(anchor);
    } else if (problem.HasParameterBlock(anchor.data())) {
      problem.SetParameterBlockConstant(anchor.data());
    }
    std::vector<int> unused_axes;
    for (int k = 3 * positioner.num_axes; k < kAxesBlockSize; ++k) unused_axes.push_back(k);
    columns.axes = Place<kAxesBlockSize>(axes.data(), unused_axes);
    for (PoseBlock& mount : mounts) columns.mount.push_back(PlacePose(mount));
    for (std::size_t s = 0; s < stop_errors.size(); ++s) {
      std::vector<int> held;
      for (int k = 0; k < kStopErrorSize; ++k) {
        if (terms.stop_error_sigma[s][k] == 0) held.push_back(k);
      }
      columns.stop_error.push_back(Place<kStopErrorSize>(stop_errors[s].data(), held));
    }
    for (PoseBlock& pose : poses) columns.pose.push_back(PlacePose(pose));
  }

  void WriteTo(ChartState& state) const {
    for (std::size_t c = 0; c < intrinsics.size(); ++c) {
      state.cameras[c].SetIntrinsics(IntrinsicVector::Map(intrinsics[c].data()));
      if (c < mounts.size() && state.rig.cam_from_mount[c]) state.rig.cam_from_mount[c] = PoseOf(mounts[c].data());
    }
    for (std::size_t s = 0; s < stop_errors.size(); ++s) state.stop_errors[s] = StopError::Map(stop_errors[s].data());
    for (std::size_t v = 0; v < poses.size(); ++v) state.cam_from_board[v] = PoseOf(poses[v].data());
    state.shape = BoardShapeOf(shape.data());
    state.place = place;
    state.rig.positioner.anchor_from_world = PoseOf(anchor.data());
    state.rig.positioner.axes_in_stage = Eigen::Matrix3d::Map(axes.data());
  }

  ChartTerms terms;
  std::vector<IntrinsicsBlock> intrinsics;
  std::vector<PoseBlock> mounts, poses;
  std::vector<StopErrorBlock> stop_errors;
  BoardShapeBlock shape;
  BoardPlace place;
  PoseBlock anchor;
  AxesBlock axes;
  std::vector<RigView> rig_views;
  std::vector<double*> free_blocks;  ///< in the order of the columns
  ChartColumns columns;
  std::vector<ceres::ResidualBlockId> residuals;  ///< corners, view by view, then priors
  std::size_t num_corner_blocks = 0;
  std::vector<int> row_of_view;
  PoseManifold pose_manifold;
  std::vector<std::unique_ptr<ceres::SubsetManifold>> subsets;
  std::unique_ptr<ceres::LossFunction> corner_loss, stop_loss;
  ceres::Problem problem;  // last: it uses the others until it is destroyed
};

ChartProblem::ChartProblem(const ChartTerms& terms, const ChartLosses& losses, const ChartState& state)
    : blocks_(std::make_unique<Blocks>(terms, losses, state)) {}
ChartProblem::~ChartProblem() = default;
ChartProblem::ChartProblem(ChartProblem&&) noexcept = default;

const ChartColumns& ChartProblem::Columns() const {
  return blocks_->columns;
}

Result<int> ChartProblem::Solve(const Execution& execution, ChartState& state) {
  ceres::Solver::Options options;
  options.num_threads = 1;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = kMaxIterations;
  options.function_tolerance = kFunctionTolerance;
  options.logging_type = ceres::SILENT;
  StopCallback stop(execution);
  options.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &blocks_->problem, &summary);
  if (execution.Stopped()) return Cancelled("seeding");
  if (!summary.IsSolutionUsable()) {
    return Fail(ErrorCode::kBadInput, "the adjustment to the chart found no solution: {}", summary.message);
  }
  blocks_->WriteTo(state);
  return static_cast<int>(summary.iterations.size());
}

ChartLinearisation ChartProblem::Linearise() {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = blocks_->free_blocks;
  options.residual_blocks = blocks_->residuals;
  options.apply_loss_function = false;
  options.num_threads = 1;
  std::vector<double> residuals;
  ceres::CRSMatrix jacobian;
  double cost = 0;
  blocks_->problem.Evaluate(options, &cost, &residuals, nullptr, &jacobian);

  ChartLinearisation out;
  out.residuals = Eigen::VectorXd::Map(residuals.data(), static_cast<Eigen::Index>(residuals.size()));
  out.row_of_view = blocks_->row_of_view;
  out.row_weight.assign(residuals.size(), 1.0);
  const int num_corner_rows = 2 * static_cast<int>(blocks_->num_corner_blocks);
  for (int row = 0; blocks_->corner_loss && row < num_corner_rows; row += 2) {
    double rho[3];
    blocks_->corner_loss->Evaluate(out.residuals.segment<2>(row).squaredNorm(), rho);
    out.row_weight[row] = out.row_weight[row + 1] = rho[1];
  }
  AddNormalEquations(jacobian, blocks_->columns.count, out);
  out.covariance = CovarianceFromInformation(out.information);
  out.degrees_of_freedom = DegreesOfFreedom(blocks_->terms, jacobian, out);
  return out;
}

}  // namespace rigcal
