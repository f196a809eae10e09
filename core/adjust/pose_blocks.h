#pragma once

#include <ceres/problem.h>

#include <memory>
#include <vector>

#include "core/adjust/bundle.h"
#include "core/rig/residuals.h"

namespace rigcal {

/// The unknowns that the views' poses depend on, in a problem of Ceres: a pose for each view, or a rig. Each kind of
/// block lies in one array: Ceres orders blocks by address, and the order decides the rounding. The terms must outlive
/// it, and it the problem.
class PoseBlocks {
 public:
  virtual ~PoseBlocks() = default;
  virtual void AddFeature(const Measurement& m, ceres::LossFunction* loss, double* intrinsics, double* point,
                          ceres::Problem& problem) = 0;
  /// What is known of them before. `intrinsics`: the cameras' blocks.
  virtual void AddPriors(std::vector<IntrinsicsBlock>& intrinsics, ceres::Problem& problem) = 0;
  /// Gives the blocks in use their manifolds and holds what is not free.
  virtual void HoldFixed(ceres::Problem& problem) = 0;
  /// All blocks, kind by kind, each kind in the order of its array.
  virtual std::vector<std::vector<double*>> Kinds() = 0;
  virtual void WriteTo(BundleUnknowns& unknowns) const = 0;
};

/// Where each of some blocks lies.
template <typename Block>
std::vector<double*> Addresses(std::vector<Block>& blocks) {
  std::vector<double*> addresses;
  for (Block& block : blocks) addresses.push_back(block.data());
  return addresses;
}

/// A pose for each view, with the seed's anchors as a prior.
std::unique_ptr<PoseBlocks> FreePoseBlocks(const BundleTerms& terms, const BundleUnknowns& start);
/// The rig of the terms.
std::unique_ptr<PoseBlocks> RigPoseBlocks(const BundleTerms& terms, const BundleUnknowns& start);

}  // namespace rigcal
