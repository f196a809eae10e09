#pragma once

#include "core/base/random.h"
#include "tests/config/example_rig.h"

namespace rigcal {

/// Two cameras at a turntable, as `seed --rig` leaves them; covariance of lens and mounts.
inline RigCalibration ExampleRigged() {
  RigCalibration rigged = ExampleRing(3);
  rigged.cameras[0].id = rigged.cameras[0].physical_id = "left";
  rigged.cameras.push_back(rigged.cameras[0]);
  rigged.cameras[1].id = rigged.cameras[1].physical_id = "right";
  rigged.views[2].camera = 1;
  RigEstimate rig{.model = Turntable(1e-3, 0, 1e-5), .axes = {"table"}};
  rig.model.cam_from_mount = {rigged.views[0].cam_from_world, rigged.views[2].cam_from_world};
  const int size = RigCovariance::Size(2);
  Random random(5);
  Eigen::MatrixXd half = Eigen::MatrixXd::Zero(size, size);
  for (int row = 0; row < RigCovariance::AnchorRow(2); ++row) {
    if (row % kNumIntrinsics == kSkew && row < RigCovariance::MountRow(2, 0)) continue;
    for (int column = 0; column < size; ++column) half(row, column) = random.Normal() * 1e-4;
  }
  const Eigen::MatrixXd joint = half * half.transpose();
  rig.covariance.joint = 0.5 * (joint + joint.transpose());
  rigged.rig = std::move(rig);
  return rigged;
}

}  // namespace rigcal
