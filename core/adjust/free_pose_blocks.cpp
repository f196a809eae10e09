#include "core/adjust/pose_blocks.h"

namespace rigcal {
namespace {

class FreePoses : public PoseBlocks {
 public:
  FreePoses(const BundleTerms& terms, const BundleUnknowns& start) : terms_(terms) {
    for (const View& view : start.calibration.views) {
      poses_.push_back(PoseBlockOf(view.cam_from_world));
      camera_of_view_.push_back(view.camera);
    }
  }

  void AddFeature(const Measurement& m, ceres::LossFunction* loss, double* intrinsics, double* point,
                  ceres::Problem& problem) override {
    problem.AddResidualBlock(new FeatureResidual(m.x_px, m.whitening), loss, intrinsics, poses_[m.view].data(), point);
  }

  void AddPriors(std::vector<IntrinsicsBlock>& intrinsics, ceres::Problem& problem) override {
    for (const SeedAnchor& anchor : terms_.anchors) {
      if (!terms_.free.poses[anchor.view]) continue;
      problem.AddResidualBlock(new AnchorResidual(anchor.x_in_world, anchor.seed_px, terms_.anchor_sigma_px), nullptr,
                               intrinsics[camera_of_view_[anchor.view]].data(), poses_[anchor.view].data());
    }
  }

  void HoldFixed(ceres::Problem& problem) override {
    for (std::size_t v = 0; v < poses_.size(); ++v) {
      if (!problem.HasParameterBlock(poses_[v].data())) continue;
      problem.SetManifold(poses_[v].data(), &manifold_);
      if (!terms_.free.poses[v]) problem.SetParameterBlockConstant(poses_[v].data());
    }
  }

  std::vector<std::vector<double*>> Kinds() override { return {Addresses(poses_)}; }

  void WriteTo(BundleUnknowns& unknowns) const override {
    for (std::size_t v = 0; v < poses_.size(); ++v) {
      if (terms_.free.poses[v]) unknowns.calibration.views[v].cam_from_world = PoseOf(poses_[v].data());
    }
  }

 private:
  const BundleTerms& terms_;
  std::vector<PoseBlock> poses_;
  std::vector<int> camera_of_view_;
  PoseManifold manifold_;
};

}  // namespace

std::unique_ptr<PoseBlocks> FreePoseBlocks(const BundleTerms& terms, const BundleUnknowns& start) {
  return std::make_unique<FreePoses>(terms, start);
}

}  // namespace rigcal
