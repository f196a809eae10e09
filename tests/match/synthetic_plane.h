#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/random.h"
#include "core/scene/image_set.h"
#include "core/scene/patch.h"
#include "core/scene/rig_calibration.h"

namespace rigcal::test {

/// A texture known everywhere: random waves on a plane, in [0, 1] around 0.5, with no detail finer than wanted.
class WaveTexture {
 public:
  /// Wavelengths between shortest and longest (units of the plane); contrast is the root mean square.
  WaveTexture(double shortest, double longest, double contrast, std::uint64_t seed);
  [[nodiscard]] double At(const Eigen::Vector2d& x) const;

 private:
  struct Wave {
    Eigen::Vector2d frequency;  ///< radians per unit
    double phase;
  };
  std::vector<Wave> waves_;
  double amplitude_;
};

/// A camera of 1000 px focal length that looks at the world's origin from `distance` away, `azimuth_rad` and
/// `elevation_rad` from the +z axis.
View LookAtOrigin(const std::string& name, double distance, double azimuth_rad, double elevation_rad,
                  double roll_rad = 0);

/// The plane z = 0 with a texture, seen by some views through one pinhole camera; pictures are point samples of the
/// exact function, so the truth is exact. One unit is about one pixel at distance 1000.
struct PlaneScene {
  RigCalibration truth;
  ImageSet images;
};
PlaneScene RenderPlane(const WaveTexture& texture, const std::vector<View>& views, cv::Size size, int num_levels,
                       double noise_sigma = 0, std::uint64_t noise_seed = 1);

/// Patches on a grid of the plane, seen by all views.
std::vector<Patch> PatchesOnPlane(int num_views, double spacing, int per_side);

/// True picture of a world point.
Eigen::Vector2d TruePixel(const RigCalibration& truth, int view, const Eigen::Vector3d& x_in_world);

/// Where the true surface that is seen at x_px of `from` is seen by `to`.
Eigen::Vector2d TransferOverPlane(const RigCalibration& truth, int from, const Eigen::Vector2d& x_px, int to);

}  // namespace rigcal::test
