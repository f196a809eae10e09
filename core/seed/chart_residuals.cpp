#include "core/seed/chart_residuals.h"

#include <algorithm>

#include "core/rig/reprojection.h"

namespace rigcal {
namespace {

template <int kCols>
void Write(const Eigen::Matrix<double, 2, kCols>& derivative, double* jacobian) {
  if (jacobian == nullptr) return;
  Eigen::Map<Eigen::Matrix<double, 2, kCols, Eigen::RowMajor>> block(jacobian);
  block = derivative;
}

Camera CameraOf(const double* intrinsics_block) {
  Camera camera;
  camera.SetIntrinsics(Eigen::Map<const IntrinsicVector>(intrinsics_block));
  return camera;
}

}  // namespace

BoardShapeBlock BlockOf(const BoardShape& shape) {
  return {shape.bow_x_m, shape.bow_y_m, shape.stretch};
}

BoardShape BoardShapeOf(const double* block) {
  return {block[0], block[1], block[2]};
}

bool HandHeldCornerResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  Eigen::Matrix3d by_shape;
  const Eigen::Vector3d x_in_board =
      TagCornerInBoard(board_, BoardShapeOf(parameters[2]), corner_.tag_id, corner_.corner, &by_shape);
  const auto seen = Reproject(CameraOf(parameters[0]), PoseOf(parameters[1]), x_in_board);
  if (!seen) return false;
  Eigen::Map<Eigen::Vector2d>(residuals).noalias() = corner_.whitening * (seen->x_px - corner_.x_px);
  if (jacobians == nullptr) return true;
  Write<kNumIntrinsics>(corner_.whitening * seen->by_intrinsics, jacobians[0]);
  Eigen::Matrix<double, 2, kPoseBlockSize> by_pose = Eigen::Matrix<double, 2, kPoseBlockSize>::Zero();
  by_pose.leftCols<6>() = corner_.whitening * seen->by_pose;
  Write<kPoseBlockSize>(by_pose, jacobians[1]);
  Write<kBoardShapeSize>(corner_.whitening * seen->by_point * by_shape, jacobians[2]);
  return true;
}

bool TableCornerResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const double* place_block = parameters[1 + kRigPoseBlocks];
  BoardPlace place;
  std::copy_n(place_block, kBoardPlaceSize, place.begin());
  Eigen::Matrix3d by_shape;
  const Eigen::Vector3d x_in_board =
      TagCornerInBoard(board_, BoardShapeOf(parameters[2 + kRigPoseBlocks]), corner_.tag_id, corner_.corner, &by_shape);
  const Rigid3d world_from_board = WorldFromBoard(place, board_.thickness_m);
  const RigPose pose = view_.PoseAt(parameters + 1);
  const auto seen = Reproject(CameraOf(parameters[0]), pose.cam_from_world, world_from_board * x_in_board);
  if (!seen) return false;
  Eigen::Map<Eigen::Vector2d>(residuals).noalias() = corner_.whitening * (seen->x_px - corner_.x_px);
  if (jacobians == nullptr) return true;
  Write<kNumIntrinsics>(corner_.whitening * seen->by_intrinsics, jacobians[0]);
  WriteRigPoseJacobians(corner_.whitening * seen->by_pose, pose, jacobians + 1);
  const Eigen::Matrix<double, 2, 3> by_world = corner_.whitening * seen->by_point;
  const Eigen::Matrix3d turned_by_tilt =
      -Skew(world_from_board.rotation * x_in_board) * LeftJacobian({place[0], place[1], 0});
  Eigen::Matrix<double, 2, kBoardPlaceSize> by_place;
  by_place << by_world * turned_by_tilt.leftCols<2>(), by_world.leftCols<2>();
  Write<kBoardPlaceSize>(by_place, jacobians[1 + kRigPoseBlocks]);
  Write<kBoardShapeSize>(by_world * world_from_board.rotation.toRotationMatrix() * by_shape,
                         jacobians[2 + kRigPoseBlocks]);
  return true;
}

}  // namespace rigcal
