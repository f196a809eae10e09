#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim_fixtures/noise.h"

namespace rigcal::sim {

/// What stands on the table.
enum class Scene {
  kTextured,  ///< a figurine, well textured at all sizes
  kPlaster,   ///< the same figurine in plaster: a few grey levels of texture, and fine relief that the light shows
  kThin,      ///< fingers, blades and rings of 2 to 5 mm, textured
  kMarker,    ///< a small plain sphere away from the axis: for testing conventions
};

std::optional<Scene> SceneFromName(std::string_view name);
std::string_view NameOf(Scene scene);
/// The names people may choose from, for messages.
std::vector<std::string> SceneNames();

/// A body as the zero of a function that is about the signed distance in metres (< 0 inside), in the world's frame:
/// standing on the plane z = 0, at the axis.
struct Shape {
  std::function<double(const Eigen::Vector3d& x_in_world)> distance_m;
  Eigen::AlignedBox3d bounds_in_world;
};

/// The reflectance of the body's material at a place: a solid texture.
struct Material {
  FractalNoise texture;
  float mean = 0.5f;
  float contrast = 0;  ///< standard deviation of the reflectance before it is limited to [kLeast, kMost]
  static constexpr float kLeast = 0.06f, kMost = 0.94f;
};

Shape ShapeOf(Scene scene);
Material MaterialOf(Scene scene);

/// Variants of an object: 0 is the object itself, the others are turned about the axis (by golden angles, so that no
/// two stand alike) and have another texture.
Shape VariantOf(const Shape& shape, int variant);
Material VariantOf(const Material& material, int variant);

/// Where the kMarker sphere is.
inline const Eigen::Vector3d kMarkerCentreInWorld_m(0.018, -0.011, 0.035);
inline constexpr double kMarkerRadius_m = 0.003;

}  // namespace rigcal::sim
