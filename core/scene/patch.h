#pragma once

#include <Eigen/Core>
#include <vector>

namespace rigcal {

/// A small oriented piece of the surface (Furukawa & Ponce's p with c(p), n(p), R(p), V(p)).
struct Patch {
  Eigen::Vector3d centre_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_in_world = Eigen::Vector3d::Zero();  ///< unit, towards the cameras that see it
  int reference_view = 0;
  std::vector<int> visible_views;  ///< ascending, contains reference_view
  float ncc = 0;                   ///< mean NCC of the visible views with the reference view
};

}  // namespace rigcal
