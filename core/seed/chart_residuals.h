#pragma once

#include <ceres/sized_cost_function.h>

#include "core/rig/rig_residuals.h"
#include "core/seed/chart_state.h"

namespace rigcal {

using BoardShapeBlock = std::array<double, kBoardShapeSize>;
BoardShapeBlock BlockOf(const BoardShape& shape);
BoardShape BoardShapeOf(const double* block);

/// A corner as detected; whitening^T whitening is the inverse of its covariance.
struct WhitenedCorner {
  int tag_id = 0, corner = 0;
  Eigen::Vector2d x_px;
  Eigen::Matrix2d whitening;
};

/// whitening * (projection - x_px) of a corner of a board in the hand. Blocks: intrinsics, cam_from_board, board shape.
class HandHeldCornerResidual : public ceres::SizedCostFunction<2, kNumIntrinsics, kPoseBlockSize, kBoardShapeSize> {
 public:
  /// `board` must outlive the residual.
  HandHeldCornerResidual(const Board& board, const WhitenedCorner& corner) : board_(board), corner_(corner) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const Board& board_;
  WhitenedCorner corner_;
};

/// The same for the board that lies in the world, seen at a stop of the rig. Blocks: intrinsics, the four of RigView,
/// board place, board shape.
class TableCornerResidual
    : public ceres::SizedCostFunction<2, kNumIntrinsics, kPoseBlockSize, kStopErrorSize, kPoseBlockSize, kAxesBlockSize,
                                      kBoardPlaceSize, kBoardShapeSize> {
 public:
  /// `board` and `view` must outlive the residual.
  TableCornerResidual(const Board& board, const RigView& view, const WhitenedCorner& corner)
      : board_(board), view_(view), corner_(corner) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const Board& board_;
  const RigView& view_;
  WhitenedCorner corner_;
};

}  // namespace rigcal
