#include "core/adjust/bundle.h"

#include <map>
#include <memory>

#include "core/adjust/pose_blocks.h"
#include "core/rig/solver.h"

namespace rigcal {
namespace {

/// Up to this many views the reduced camera system is solved as a dense matrix (6 * 100 rows: 3 MB).
constexpr int kMaxDenseViews = 100;

ceres::Problem::Options ProblemOptions() {
  ceres::Problem::Options options = SharingProblemOptions();
  options.disable_all_safety_checks = true;  // they cost as much as the rest of the set-up
  return options;
}

/// The unknowns as Ceres sees them, and the problem over them. Each kind lies in one array: Ceres orders blocks by
/// address, and the order decides the rounding.
class Bundle {
 public:
  Bundle(const BundleTerms& terms, double cauchy_scale, const BundleUnknowns& start)
      : points_(start.measurements.x_in_world),
        num_views_(start.calibration.NumViews()),
        poses_(terms.rig ? RigPoseBlocks(terms, start) : FreePoseBlocks(terms, start)),
        problem_(ProblemOptions()) {
    for (const Camera& camera : start.calibration.cameras) {
      IntrinsicVector::Map(intrinsics_.emplace_back().data()) = camera.Intrinsics();
    }
    for (const Measurement& m : start.measurements.items) {
      poses_->AddFeature(m, LossOf(m.weight, cauchy_scale), intrinsics_[start.calibration.views[m.view].camera].data(),
                         points_[m.point].data(), problem_);
    }
    poses_->AddPriors(intrinsics_, problem_);
    for (std::size_t c = 0; c < terms.camera_priors.size(); ++c) {
      problem_.AddResidualBlock(new IntrinsicsResidual(terms.camera_priors[c]), nullptr, intrinsics_[c].data());
    }
    poses_->HoldFixed(problem_);
    HoldFixed(terms.free);
  }

  Result<int> Solve(const BundleLimits& limits, const Execution& execution) {
    ceres::Solver::Options options;
    options.num_threads = 1;
    options.linear_solver_type = num_views_ <= kMaxDenseViews ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.dense_linear_algebra_library_type = ceres::EIGEN;
    options.linear_solver_ordering = PointsFirst();
    options.max_num_iterations = limits.max_iterations;
    options.function_tolerance = limits.function_tolerance;
    options.parameter_tolerance = 0;
    options.gradient_tolerance = 0;
    options.initial_trust_region_radius = limits.initial_trust_region_radius;
    options.logging_type = ceres::SILENT;
    StopCallback stop(execution);
    options.callbacks.push_back(&stop);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (execution.Stopped()) return Cancelled("bundle adjustment");
    if (!summary.IsSolutionUsable()) {
      return Fail(ErrorCode::kBadInput, "bundle adjustment of {} points found no solution: {}", points_.size(),
                  summary.message);
    }
    return static_cast<int>(summary.iterations.size());
  }

  void WriteTo(BundleUnknowns& unknowns) const {
    for (std::size_t c = 0; c < intrinsics_.size(); ++c) {
      unknowns.calibration.cameras[c].SetIntrinsics(IntrinsicVector::Map(intrinsics_[c].data()));
    }
    poses_->WriteTo(unknowns);
    unknowns.measurements.x_in_world = points_;
  }

 private:
  /// The loss of all features of a weight; its scale stays that of one feature.
  ceres::LossFunction* LossOf(double weight, double cauchy_scale) {
    auto& loss = losses_[weight];
    if (!loss) {
      ceres::LossFunction* robust = cauchy_scale > 0 ? new ceres::CauchyLoss(cauchy_scale) : nullptr;
      loss = std::make_unique<ceres::ScaledLoss>(robust, weight, ceres::TAKE_OWNERSHIP);
    }
    return loss.get();
  }

  void HoldFixed(const FreeParameters& free) {
    for (std::size_t c = 0; c < intrinsics_.size(); ++c) {
      double* block = intrinsics_[c].data();
      if (!problem_.HasParameterBlock(block)) continue;
      std::vector<int> held;
      for (int k = 0; k < kNumIntrinsics; ++k) {
        if (!free.intrinsics[c][k]) held.push_back(k);
      }
      if (held.size() == kNumIntrinsics) {
        problem_.SetParameterBlockConstant(block);
      } else if (!held.empty()) {
        subsets_.push_back(std::make_unique<ceres::SubsetManifold>(kNumIntrinsics, held));
        problem_.SetManifold(block, subsets_.back().get());
      }
    }
  }

  std::shared_ptr<ceres::ParameterBlockOrdering> PointsFirst() {
    std::vector<std::vector<double*>> kinds = {Addresses(points_), Addresses(intrinsics_)};
    for (std::vector<double*>& kind : poses_->Kinds()) kinds.push_back(std::move(kind));
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (std::size_t group = 0; group < kinds.size(); ++group) {
      for (double* block : kinds[group]) {
        if (problem_.HasParameterBlock(block)) ordering->AddElementToGroup(block, static_cast<int>(group));
      }
    }
    return ordering;
  }

  std::vector<IntrinsicsBlock> intrinsics_;
  std::vector<Eigen::Vector3d> points_;
  int num_views_;
  std::unique_ptr<PoseBlocks> poses_;
  std::vector<std::unique_ptr<ceres::SubsetManifold>> subsets_;
  std::map<double, std::unique_ptr<ceres::LossFunction>> losses_;  ///< by weight: one for each view and source
  ceres::Problem problem_;                                         // last: it uses the others until it is destroyed
};

}  // namespace

Result<int> SolveBundle(const BundleTerms& terms, const BundleLimits& limits, const Execution& execution,
                        BundleUnknowns& unknowns) {
  Bundle bundle(terms, limits.cauchy_scale, unknowns);
  Result<int> iterations = bundle.Solve(limits, execution);
  if (iterations) bundle.WriteTo(unknowns);
  return iterations;
}

}  // namespace rigcal
