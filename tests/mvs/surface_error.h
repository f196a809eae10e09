#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/scene/patch.h"
#include "tests/support/synthetic_surface.h"

namespace rigcal::test {

inline constexpr double kDegree = std::numbers::pi / 180;

/// A ball of 64 pixels (level 0) seen from all around its equator. No wave is shorter than 6 pixels of level 1, the
/// level on which most is tested.
inline constexpr double kBallRadius = 64;
inline constexpr int kBallLevel = 1;
inline constexpr int kBallViews = 14;

inline const SurfaceScene& BallScene() {
  static const SurfaceScene scene = RenderSurface(SphereAtOrigin(kBallRadius), SolidTexture(12, 40, 0.12, 5),
                                                  ViewsAround(kBallViews, 20 * kDegree), {160, 160}, 2);
  return scene;
}

/// The value below which a share of the values lies.
inline double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

/// How far patches lie before (towards the outside, positive) the true ball, pixels of the level, and how far their
/// normals are turned.
struct BallErrors {
  std::vector<double> distance_px, absolute_px, turn_rad;
  double mean_px = 0;
};

inline BallErrors ErrorsOnBall(const std::vector<Patch>& patches, int level) {
  BallErrors errors;
  for (const Patch& patch : patches) {
    const double distance_px = (patch.centre_in_world.norm() - kBallRadius) * std::ldexp(1.0, -level);
    errors.distance_px.push_back(distance_px);
    errors.absolute_px.push_back(std::abs(distance_px));
    errors.turn_rad.push_back(std::acos(std::min(1.0, patch.normal_in_world.dot(patch.centre_in_world.normalized()))));
    errors.mean_px += distance_px / static_cast<double>(patches.size());
  }
  return errors;
}

}  // namespace rigcal::test
