#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/image_set.h"
#include "core/scene/rig_calibration.h"

namespace rigcal::test {

/// A texture known everywhere in space: random waves, in [0, 1] around 0.5, with no detail finer than wanted. A surface
/// cut through it shows no wave shorter than `shortest`.
class SolidTexture {
 public:
  /// Wavelengths between shortest and longest (units of the world); contrast is the root mean square.
  SolidTexture(double shortest, double longest, double contrast, std::uint64_t seed);
  [[nodiscard]] double At(const Eigen::Vector3d& x_in_world) const;

 private:
  struct Wave {
    Eigen::Vector3d frequency;  ///< radians per unit
    double phase;
  };
  std::vector<Wave> waves_;
  double amplitude_;
};

/// How many `direction`s from `origin` (both in the world) a ray first meets a surface; nothing when it misses.
using FirstHit =
    std::function<std::optional<double>(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& direction)>;
FirstHit PlaneAtHeight(double z_in_world);
FirstHit SphereAtOrigin(double radius);
FirstHit NearerOf(FirstHit a, FirstHit b);

/// The cameras stand this far from the origin and have this focal length: one unit is about one pixel.
inline constexpr double kSceneDistance = 1000;
inline constexpr double kSceneFocalLengthPx = 1000;

/// Looks at the origin from a direction, turned about its own axis by roll_rad. Views with different rolls do not let a
/// shift common to all pictures (half a pixel, say) pass for a motion of the object.
View ViewOfOrigin(const std::string& name, const Eigen::Vector3d& from_in_world, double roll_rad);

/// `count` views around the +z axis, `tilt_rad` from it, and one (the first) on it; rolls all different.
std::vector<View> ViewsAboutZ(int count, double tilt_rad);

/// `count` views around the object's y axis, in turn above and below its equator by elevation_rad; rolls all different.
std::vector<View> ViewsAround(int count, double elevation_rad);

struct SurfaceScene {
  RigCalibration truth;
  ImageSet images;
};

/// A textured surface seen through one pinhole camera. Pictures are point samples of the exact function, so the truth
/// is exact. Where a ray misses, the picture is black; then every view has a mask.
SurfaceScene RenderSurface(const FirstHit& surface, const SolidTexture& texture, const std::vector<View>& views,
                           cv::Size size, int num_levels);

/// Normal noise on the full-size pictures; their pyramids are built anew.
ImageSet WithNoise(const ImageSet& images, double sigma, std::uint64_t seed);

/// True picture of a world point, full size.
Eigen::Vector2d TrueImage(const RigCalibration& truth, int view, const Eigen::Vector3d& x_in_world);

/// Views turned so that everything they see moves by so many full-size pixels (to the right and down).
RigCalibration WithShiftedViews(const RigCalibration& truth, const std::vector<Eigen::Vector2d>& shift_px);

}  // namespace rigcal::test
