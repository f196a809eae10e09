#include "core/seed/axis_on_board.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rigcal {
namespace {

constexpr double kThickness_m = 0.005;
const BoardPlace kPlace = {0.35, -0.2, 0.04, -0.03};

Eigen::Matrix<double, 5, 1> Five(const BoardPlace& place) {
  const AxisOnBoard axis = AxisOnBoardOf(place, kThickness_m, Eigen::Matrix4d::Zero());
  Eigen::Matrix<double, 5, 1> five;
  five << axis.direction_in_board, axis.point_in_board;
  return five;
}

TEST(AxisOnBoard, AFlatBoardSaysWhereItsOriginLies) {
  const AxisOnBoard axis = AxisOnBoardOf({0, 0, 0.04, -0.03}, kThickness_m, Eigen::Matrix4d::Zero());
  EXPECT_LT((axis.direction_in_board - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((axis.point_in_board - Eigen::Vector2d(-0.04, 0.03)).norm(), 1e-12);
}

TEST(AxisOnBoard, ThePointLiesOnTheAxisInTheWorld) {
  const AxisOnBoard axis = AxisOnBoardOf(kPlace, kThickness_m, Eigen::Matrix4d::Zero());
  const Rigid3d world_from_board = WorldFromBoard(kPlace, kThickness_m);
  const Eigen::Vector3d in_world =
      world_from_board * Eigen::Vector3d(axis.point_in_board.x(), axis.point_in_board.y(), 0);
  EXPECT_LT(in_world.head<2>().norm(), 1e-12);
  EXPECT_LT((world_from_board.rotation * axis.direction_in_board - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(AxisOnBoard, DerivativeAgreesWithDifferences) {
  constexpr double kStep = 1e-6;
  const Eigen::Matrix<double, 5, kBoardPlaceSize> analytic = AxisOnBoardByPlace(kPlace, kThickness_m);
  for (int k = 0; k < kBoardPlaceSize; ++k) {
    BoardPlace more = kPlace, less = kPlace;
    more[k] += kStep, less[k] -= kStep;
    const Eigen::Matrix<double, 5, 1> difference = (Five(more) - Five(less)) / (2 * kStep);
    EXPECT_LT((analytic.col(k) - difference).norm(), 1e-8) << "place " << k;
  }
}

TEST(AxisOnBoard, SigmasOfAFlatBoardAreThoseOfItsPlace) {
  const Eigen::Vector4d sigma(1e-4, 1e-4, 2e-5, 2e-5);
  const AxisOnBoard axis = AxisOnBoardOf({0, 0, 0.04, -0.03}, 0, sigma.cwiseAbs2().asDiagonal());
  EXPECT_NEAR(axis.direction_sigma_rad, 1e-4, 1e-12);
  EXPECT_NEAR(axis.point_sigma_m, 2e-5, 1e-12);
}

}  // namespace
}  // namespace rigcal
