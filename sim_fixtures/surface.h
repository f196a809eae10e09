#pragma once

#include <optional>
#include <vector>

#include "sim_fixtures/studio.h"

namespace rigcal::sim {

/// The true surface under a pixel of the original (distorted) picture of a view; nothing beside object and table top.
std::optional<SurfacePoint> SurfaceAt(const Studio& studio, int view, const Eigen::Vector2d& x_px);

/// A point of the true surface of the object with the views that see it: before the camera, inside the picture, not
/// occluded, and less than kSteepestView_deg from the normal.
struct VisiblePoint {
  Eigen::Vector3d x_in_world;
  Eigen::Vector3d normal_in_world;
  std::vector<int> views;  ///< ascending
};
inline constexpr double kSteepestView_deg = 80;

/// About `count` points, even over the object's surface, each seen by at least min_views views. Fewer when the cameras
/// see little of it.
std::vector<VisiblePoint> SurfacePoints(const Studio& studio, int count, int min_views);

/// How far points lie from the true surface (object, and table top where there is one), in pixels of the full size as
/// seen from the cameras: the distance to the nearest surface point times focal length / depth, median over the views.
/// Points farther away than kFarthest_m count as that far. Independent of the number of threads; empty when stopped.
std::vector<double> DistancesToSurface_px(const Studio& studio, const std::vector<Eigen::Vector3d>& points_in_world,
                                          const Execution& execution);
inline constexpr double kFarthest_m = 0.05;

}  // namespace rigcal::sim
