#include "core/adjust/bundle.h"

#include <algorithm>
#include <map>
#include <memory>

#include "core/rig/residuals.h"
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
  Bundle(const BundleTerms& terms, double cauchy_scale, const RigCalibration& calibration,
         const MeasurementSet& measurements)
      : points_(measurements.x_in_world), problem_(ProblemOptions()) {
    for (const Camera& camera : calibration.cameras) {
      IntrinsicVector::Map(intrinsics_.emplace_back().data()) = camera.Intrinsics();
    }
    for (const View& view : calibration.views) poses_.push_back(PoseBlockOf(view.cam_from_world));
    AddFeatures(cauchy_scale, calibration, measurements);
    AddPriors(terms, calibration);
    HoldFixed(terms.free);
  }

  Result<int> Solve(const BundleLimits& limits, const Execution& execution) {
    ceres::Solver::Options options;
    options.num_threads = 1;
    options.linear_solver_type =
        static_cast<int>(poses_.size()) <= kMaxDenseViews ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
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

  void WriteTo(const FreeParameters& free, RigCalibration& calibration, MeasurementSet& measurements) const {
    for (std::size_t c = 0; c < intrinsics_.size(); ++c) {
      calibration.cameras[c].SetIntrinsics(IntrinsicVector::Map(intrinsics_[c].data()));
    }
    for (std::size_t v = 0; v < poses_.size(); ++v) {
      if (free.poses[v]) calibration.views[v].cam_from_world = PoseOf(poses_[v].data());
    }
    measurements.x_in_world = points_;
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

  void AddFeatures(double cauchy_scale, const RigCalibration& calibration, const MeasurementSet& measurements) {
    for (const Measurement& m : measurements.items) {
      problem_.AddResidualBlock(new FeatureResidual(m.x_px, m.whitening), LossOf(m.weight, cauchy_scale),
                                intrinsics_[calibration.views[m.view].camera].data(), poses_[m.view].data(),
                                points_[m.point].data());
    }
  }

  void AddPriors(const BundleTerms& terms, const RigCalibration& calibration) {
    for (const SeedAnchor& anchor : terms.anchors) {
      if (!terms.free.poses[anchor.view]) continue;
      problem_.AddResidualBlock(new AnchorResidual(anchor.x_in_world, anchor.seed_px, terms.anchor_sigma_px), nullptr,
                                intrinsics_[calibration.views[anchor.view].camera].data(), poses_[anchor.view].data());
    }
    for (std::size_t c = 0; c < terms.camera_priors.size(); ++c) {
      problem_.AddResidualBlock(new IntrinsicsResidual(terms.camera_priors[c]), nullptr, intrinsics_[c].data());
    }
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
    for (std::size_t v = 0; v < poses_.size(); ++v) {
      if (!problem_.HasParameterBlock(poses_[v].data())) continue;
      problem_.SetManifold(poses_[v].data(), &pose_manifold_);
      if (!free.poses[v]) problem_.SetParameterBlockConstant(poses_[v].data());
    }
  }

  std::shared_ptr<ceres::ParameterBlockOrdering> PointsFirst() {
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (auto& point : points_) ordering->AddElementToGroup(point.data(), 0);
    for (auto& block : intrinsics_) {
      if (problem_.HasParameterBlock(block.data())) ordering->AddElementToGroup(block.data(), 1);
    }
    for (auto& block : poses_) {
      if (problem_.HasParameterBlock(block.data())) ordering->AddElementToGroup(block.data(), 2);
    }
    return ordering;
  }

  std::vector<IntrinsicsBlock> intrinsics_;
  std::vector<PoseBlock> poses_;
  std::vector<Eigen::Vector3d> points_;
  PoseManifold pose_manifold_;
  std::vector<std::unique_ptr<ceres::SubsetManifold>> subsets_;
  std::map<double, std::unique_ptr<ceres::LossFunction>> losses_;  ///< by weight: one for each view and source
  ceres::Problem problem_;                                         // last: it uses the others until it is destroyed
};

}  // namespace

Result<int> SolveBundle(const BundleTerms& terms, const BundleLimits& limits, const Execution& execution,
                        RigCalibration& calibration, MeasurementSet& measurements) {
  Bundle bundle(terms, limits.cauchy_scale, calibration, measurements);
  Result<int> iterations = bundle.Solve(limits, execution);
  if (iterations) bundle.WriteTo(terms.free, calibration, measurements);
  return iterations;
}

}  // namespace rigcal
