#include "core/seed/axis_on_board.h"

#include <cmath>

#include "core/rig/rig_model_pose.h"

namespace rigcal {
namespace {

/// The axis in the board's frame: its direction, and the world's origin, which lies on it.
struct AxisLine {
  Eigen::Vector3d direction, origin;
};

AxisLine LineOf(const Rigid3d& world_from_board) {
  const Rigid3d board_from_world = world_from_board.Inverse();
  return {board_from_world.rotation * Eigen::Vector3d::UnitZ(), board_from_world.translation};
}

}  // namespace

Eigen::Matrix<double, 5, kBoardPlaceSize> AxisOnBoardByPlace(const BoardPlace& place, double thickness_m) {
  const Rigid3d world_from_board = WorldFromBoard(place, thickness_m);
  const AxisLine line = LineOf(world_from_board);
  const Eigen::Matrix3d board_from_world = world_from_board.rotation.conjugate().toRotationMatrix();
  const Eigen::Matrix3d turned_by_tilt = LeftJacobian({place[0], place[1], 0});
  Eigen::Matrix<double, 3, kBoardPlaceSize> direction, origin;
  direction << (board_from_world * Skew(Eigen::Vector3d::UnitZ()) * turned_by_tilt).leftCols<2>(),
      Eigen::Matrix<double, 3, 2>::Zero();
  origin << (-board_from_world * Skew(world_from_board.translation) * turned_by_tilt).leftCols<2>(),
      -board_from_world.leftCols<2>();
  // point = origin - direction * origin.z / direction.z
  const double along = line.origin.z() / line.direction.z();
  const Eigen::RowVector4d by_along = (origin.row(2) - along * direction.row(2)) / line.direction.z();
  const Eigen::Matrix<double, 3, kBoardPlaceSize> point = origin - along * direction - line.direction * by_along;
  Eigen::Matrix<double, 5, kBoardPlaceSize> out;
  out << direction, point.topRows<2>();
  return out;
}

AxisOnBoard AxisOnBoardOf(const BoardPlace& place, double thickness_m, const Eigen::Matrix4d& covariance) {
  const AxisLine line = LineOf(WorldFromBoard(place, thickness_m));
  const Eigen::Matrix<double, 5, kBoardPlaceSize> by_place = AxisOnBoardByPlace(place, thickness_m);
  const Eigen::Matrix<double, 5, 5> spread = by_place * covariance * by_place.transpose();
  AxisOnBoard axis;
  axis.direction_in_board = line.direction;
  axis.point_in_board = (line.origin - line.direction * (line.origin.z() / line.direction.z())).head<2>();
  // The direction is a unit vector: all of its spread lies across it.
  axis.direction_sigma_rad = std::sqrt(spread.topLeftCorner<3, 3>().trace() / 2);
  axis.point_sigma_m = std::sqrt(spread.bottomRightCorner<2, 2>().trace() / 2);
  return axis;
}

}  // namespace rigcal
