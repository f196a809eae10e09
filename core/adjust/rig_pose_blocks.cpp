#include <ceres/normal_prior.h>

#include "core/adjust/pose_blocks.h"
#include "core/rig/rig_model_pose.h"
#include "core/rig/rig_prior.h"
#include "core/rig/rig_residuals.h"

namespace rigcal {
namespace {

class RigPoses : public PoseBlocks {
 public:
  RigPoses(const BundleTerms& terms, const BundleUnknowns& start) : rig_(*terms.rig) {
    const RigModel& model = start.rig->model;
    for (const auto& mount : model.cam_from_mount) mounts_.push_back(PoseBlockOf(mount.value_or(Rigid3d{})));
    for (const StopError& error : start.rig->stop_errors) {
      StopError::Map(stop_errors_.emplace_back().data()) = error;
    }
    anchor_ = PoseBlockOf(model.positioner.anchor_from_world);
    Eigen::Matrix3d::Map(axes_.data()) = model.positioner.axes_in_stage;
    for (std::size_t v = 0; v < start.calibration.views.size(); ++v) {
      views_.push_back({model.positioner, rig_.stops[rig_.stop_of_view[v]]});
      camera_of_view_.push_back(start.calibration.views[v].camera);
    }
  }

  void AddFeature(const Measurement& m, ceres::LossFunction* loss, double* intrinsics, double* point,
                  ceres::Problem& problem) override {
    problem.AddResidualBlock(new RigFeatureResidual(views_[m.view], m.x_px, m.whitening), loss, intrinsics,
                             mounts_[camera_of_view_[m.view]].data(), stop_errors_[rig_.stop_of_view[m.view]].data(),
                             anchor_.data(), axes_.data(), point);
  }

  void AddPriors(std::vector<IntrinsicsBlock>& intrinsics, ceres::Problem& problem) override {
    std::vector<double*> blocks = Addresses(intrinsics);
    for (double* mount : Addresses(mounts_)) blocks.push_back(mount);
    blocks.insert(blocks.end(), {anchor_.data(), axes_.data()});
    if (!rig_.prior.FreeRows().empty()) problem.AddResidualBlock(new RigPriorResidual(rig_.prior), nullptr, blocks);
    for (std::size_t s = 0; s < stop_errors_.size(); ++s) {
      const StopError weight =
          rig_.stop_error_sigma[s].unaryExpr([](double sigma) { return sigma > 0 ? 1 / sigma : 0.0; });
      problem.AddResidualBlock(new ceres::NormalPrior(weight.asDiagonal(), StopError::Zero()), nullptr,
                               stop_errors_[s].data());
    }
  }

  void HoldFixed(ceres::Problem& problem) override {
    const int n = static_cast<int>(mounts_.size());
    const Eigen::VectorXd variance = rig_.prior.covariance.joint.diagonal();
    const auto hold_pose = [&](PoseBlock& block, int row) {
      problem.SetManifold(block.data(), &pose_manifold_);
      if ((variance.segment<6>(row).array() == 0).all()) problem.SetParameterBlockConstant(block.data());
    };
    for (int c = 0; c < n; ++c) hold_pose(mounts_[c], RigCovariance::MountRow(n, c));
    hold_pose(anchor_, RigCovariance::AnchorRow(n));
    Hold<kAxesBlockSize>(variance.segment<kAxesBlockSize>(RigCovariance::AxesRow(n)), axes_.data(), problem);
    for (std::size_t s = 0; s < stop_errors_.size(); ++s) {
      Hold<kStopErrorSize>(rig_.stop_error_sigma[s], stop_errors_[s].data(), problem);
    }
  }

  std::vector<std::vector<double*>> Kinds() override {
    return {Addresses(mounts_), Addresses(stop_errors_), {anchor_.data()}, {axes_.data()}};
  }

  void WriteTo(BundleUnknowns& unknowns) const override {
    RigState& rig = *unknowns.rig;
    for (std::size_t c = 0; c < mounts_.size(); ++c) {
      if (rig.model.cam_from_mount[c]) rig.model.cam_from_mount[c] = PoseOf(mounts_[c].data());
    }
    for (std::size_t s = 0; s < stop_errors_.size(); ++s) {
      rig.stop_errors[s] = Eigen::Map<const StopError>(stop_errors_[s].data());
    }
    rig.model.positioner.anchor_from_world = PoseOf(anchor_.data());
    rig.model.positioner.axes_in_stage = Eigen::Map<const Eigen::Matrix3d>(axes_.data());
    PlaceViews(rig.model, rig_.stops, rig.stop_errors, rig_.stop_of_view, unknowns.calibration);
  }

 private:
  /// Holds the components whose prior has no width.
  template <int kSize>
  void Hold(const Eigen::Matrix<double, kSize, 1>& width, double* block, ceres::Problem& problem) {
    std::vector<int> held;
    for (int k = 0; k < kSize; ++k) {
      if (width[k] == 0) held.push_back(k);
    }
    if (held.size() == kSize) {
      problem.SetParameterBlockConstant(block);
    } else if (!held.empty()) {
      subsets_.push_back(std::make_unique<ceres::SubsetManifold>(kSize, held));
      problem.SetManifold(block, subsets_.back().get());
    }
  }

  const RigTerms& rig_;
  std::vector<PoseBlock> mounts_;
  std::vector<StopErrorBlock> stop_errors_;
  PoseBlock anchor_;
  AxesBlock axes_;
  std::vector<RigView> views_;
  std::vector<int> camera_of_view_;
  PoseManifold pose_manifold_;
  std::vector<std::unique_ptr<ceres::SubsetManifold>> subsets_;
};

}  // namespace

std::unique_ptr<PoseBlocks> RigPoseBlocks(const BundleTerms& terms, const BundleUnknowns& start) {
  return std::make_unique<RigPoses>(terms, start);
}

}  // namespace rigcal
