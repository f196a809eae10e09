#include "sim_fixtures/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace rigcal::sim {
namespace {

using Eigen::Vector3d;

constexpr std::array<std::pair<std::string_view, Scene>, 4> kNames = {
    {{"textured", Scene::kTextured}, {"plaster", Scene::kPlaster}, {"thin", Scene::kThin}, {"marker", Scene::kMarker}}};

double Ball(const Vector3d& x, const Vector3d& centre, double radius) {
  return (x - centre).norm() - radius;
}

/// First-order distance to an ellipsoid with the given half axes.
double Ellipsoid(const Vector3d& x, const Vector3d& centre, const Vector3d& half_axes) {
  const Vector3d scaled = (x - centre).cwiseQuotient(half_axes);
  const double k0 = scaled.norm();
  const double k1 = scaled.cwiseQuotient(half_axes).norm();
  return k1 < 1e-12 ? -half_axes.minCoeff() : k0 * (k0 - 1) / k1;
}

double Capsule(const Vector3d& x, const Vector3d& a, const Vector3d& b, double radius) {
  const Vector3d along = b - a;
  const double t = std::clamp((x - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (x - a - t * along).norm() - radius;
}

/// Upright cylinder from height low to high with rounded edges.
double Disc(const Vector3d& x, double radius, double low, double high, double rounding) {
  const double across = std::hypot(x.x(), x.y()) - (radius - rounding);
  const double up = std::abs(x.z() - 0.5 * (low + high)) - (0.5 * (high - low) - rounding);
  return std::min(std::max(across, up), 0.0) + std::hypot(std::max(across, 0.0), std::max(up, 0.0)) - rounding;
}

/// Ring about `axis` (unit).
double Torus(const Vector3d& x, const Vector3d& centre, const Vector3d& axis, double ring_radius, double tube_radius) {
  const double up = (x - centre).dot(axis);
  const double across = (x - centre - up * axis).norm() - ring_radius;
  return std::hypot(across, up) - tube_radius;
}

/// Upright plate through the axis at `azimuth_rad`: from `inner` to `outer` away from the axis, rounded.
double Plate(const Vector3d& x, double azimuth_rad, const Vector3d& centre, const Vector3d& half_size,
             double rounding) {
  const Vector3d local = Eigen::AngleAxisd(-azimuth_rad, Vector3d::UnitZ()) * x - centre;
  const Vector3d beyond = local.cwiseAbs() - (half_size - Vector3d::Constant(rounding));
  return beyond.cwiseMax(0).norm() + std::min(beyond.maxCoeff(), 0.0) - rounding;
}

/// Union with a fillet of about `blend` metres.
double SmoothUnion(double a, double b, double blend) {
  const double h = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - 0.25 * h * h * blend;
}

constexpr double mm = 1e-3;
constexpr double kStout = 1.25;  ///< the figurine is wider than drawn, to fill pictures of 4:3

/// About 0.18 m tall, without any symmetry: a seated animal on a plinth.
double Figurine(const Vector3d& x_in_world) {
  const Vector3d x = x_in_world.cwiseQuotient(Vector3d(kStout, kStout, 1)) / mm;
  double d = Ellipsoid(x, {0, 2, 55}, {37, 31, 47});
  d = SmoothUnion(d, Ellipsoid(x, {1, 0, 102}, {28, 23, 32}), 12);
  d = SmoothUnion(d, Ellipsoid(x, {3, -6, 149}, {22, 21, 20}), 6);
  d = SmoothUnion(d, Capsule(x, {4, -22, 147}, {5, -32, 142}, 5.5), 5);
  d = SmoothUnion(d, Capsule(x, {-12, 2, 163}, {-17, 4, 174}, 5), 4);
  d = SmoothUnion(d, Capsule(x, {17, 0, 163}, {24, 2, 172}, 5), 4);
  const double right =
      std::min(Capsule(x, {25, 0, 112}, {46, -10, 84}, 8), Capsule(x, {46, -10, 84}, {26, -36, 80}, 7));
  const double left =
      std::min(Capsule(x, {-25, 0, 114}, {-43, 8, 128}, 7.5), Capsule(x, {-43, 8, 128}, {-38, -6, 156}, 6.5));
  d = SmoothUnion(d, std::min(right, left), 5);
  const double tail = std::min(Capsule(x, {0, 28, 28}, {8, 50, 52}, 8), Capsule(x, {8, 50, 52}, {-4, 46, 96}, 7));
  d = SmoothUnion(d, tail, 5);
  d = SmoothUnion(d, Capsule(x, {22, -20, 22}, {30, -36, 19}, 10), 5);
  d = SmoothUnion(d, Capsule(x, {-20, -22, 22}, {-24, -38, 18}, 9), 5);
  d = SmoothUnion(d, Ball(x, {18, -34, 78}, 11), 3);
  d = SmoothUnion(d, Disc(x, 46, 0, 14, 3), 4);
  d = std::max(d, -Torus(x, {0, 0, 124}, {0, 0.0998334, 0.9950042}, 24, 2.5));  // a groove: the collar
  return d * mm;
}

/// About 0.17 m tall; the thinnest parts are 1.8 mm.
double ThinParts(const Vector3d& x_in_world) {
  const Vector3d x = x_in_world / mm;
  double d = Ellipsoid(x, {0, 0, 66}, {23, 20, 50});
  const std::array<Vector3d, 5> tips = {Vector3d{-34, -6, 146}, Vector3d{-16, -16, 164}, Vector3d{2, 10, 170},
                                        Vector3d{20, -12, 162}, Vector3d{36, 8, 140}};
  double fingers = 1e3;
  for (const Vector3d& tip : tips) {
    const Vector3d root(0.3 * tip.x(), 0.3 * tip.y(), 104), knuckle(0.8 * tip.x(), 0.8 * tip.y(), 128);
    fingers = std::min({fingers, Capsule(x, root, knuckle, 2.6), Capsule(x, knuckle, tip, 2.0)});
  }
  d = SmoothUnion(d, fingers, 3);
  const Vector3d ring_axis = Vector3d(0.35, 0.15, 1).normalized();
  const Vector3d ring_centre(0, 0, 74);
  double ring = Torus(x, ring_centre, ring_axis, 46, 1.8);
  const Vector3d u = ring_axis.unitOrthogonal(), v = ring_axis.cross(u);
  for (int spoke = 0; spoke < 3; ++spoke) {
    const double angle = 2 * std::numbers::pi / 3 * spoke;
    ring = std::min(ring, Capsule(x, ring_centre, ring_centre + 46 * (std::cos(angle) * u + std::sin(angle) * v), 1.3));
  }
  d = SmoothUnion(d, ring, 2);
  double blades = 1e3;
  for (int blade = 0; blade < 5; ++blade) {
    const double azimuth = 2 * std::numbers::pi / 5 * blade + 0.3;
    blades = std::min(blades, Plate(x, azimuth, {30, 0, 28 + 3.0 * blade}, {17, 0.9, 16}, 0.6));
  }
  d = SmoothUnion(d, blades, 2);
  d = SmoothUnion(d, Disc(x, 44, 0, 9, 2), 2);
  return d * mm;
}

/// Relief that is carved into a body: amplitude is its standard deviation.
std::function<double(const Vector3d&)> Carved(double (*body)(const Vector3d&), FractalNoise relief,
                                              double amplitude_m) {
  return [=](const Vector3d& x) {
    const double distance = body(x);
    // Far from the surface the relief makes no difference.
    if (std::abs(distance) > 6 * amplitude_m + 1e-3) return distance;
    return distance + amplitude_m * static_cast<double>(NoiseAt(relief, static_cast<float>(x.x()),
                                                                static_cast<float>(x.y()), static_cast<float>(x.z())));
  };
}

}  // namespace

std::optional<Scene> SceneFromName(std::string_view name) {
  for (const auto& [known, scene] : kNames) {
    if (known == name) return scene;
  }
  return std::nullopt;
}

std::string_view NameOf(Scene scene) {
  for (const auto& [name, known] : kNames) {
    if (known == scene) return name;
  }
  return "";
}

std::vector<std::string> SceneNames() {
  std::vector<std::string> names;
  for (const auto& [name, scene] : kNames) {
    if (scene != Scene::kMarker) names.emplace_back(name);
  }
  return names;
}

Shape ShapeOf(Scene scene) {
  const Eigen::AlignedBox3d figurine_bounds(Vector3d(-0.075, -0.072, -0.004), Vector3d(0.077, 0.083, 0.188));
  const Eigen::AlignedBox3d thin_bounds(Vector3d(-0.058, -0.058, -0.004), Vector3d(0.058, 0.058, 0.180));
  const FractalNoise coarse{.longest_m = 0.024f, .num_octaves = 2, .gain = 0.4f, .seed = 11};
  const FractalNoise fine{.longest_m = 0.012f, .num_octaves = 3, .gain = 0.42f, .seed = 12};
  switch (scene) {
    case Scene::kTextured:
      return {Carved(Figurine, coarse, 0.0006), figurine_bounds};
    case Scene::kPlaster:
      return {Carved(Figurine, fine, 0.0004), figurine_bounds};
    case Scene::kThin:
      return {ThinParts, thin_bounds};
    case Scene::kMarker:
      break;
  }
  const Vector3d reach = Vector3d::Constant(2 * kMarkerRadius_m);
  return {[](const Vector3d& x) { return Ball(x, kMarkerCentreInWorld_m, kMarkerRadius_m); },
          {kMarkerCentreInWorld_m - reach, kMarkerCentreInWorld_m + reach}};
}

Material MaterialOf(Scene scene) {
  // Octaves from 14 mm down to 0.9 mm: from two pixels of level 3 to three of level 0 in pictures of one megapixel.
  const FractalNoise all_sizes{.longest_m = 0.014f, .num_octaves = 5, .gain = 0.85f, .seed = 1};
  switch (scene) {
    case Scene::kTextured:
      return {.texture = all_sizes, .mean = 0.45f, .contrast = 0.20f};
    case Scene::kThin:
      return {.texture = all_sizes, .mean = 0.50f, .contrast = 0.18f};
    case Scene::kPlaster:
      // 2 % of the reflectance: about two grey levels at 8 bit after the gamma curve (DESIGN.md section 3: "weak").
      return {.texture = all_sizes, .mean = 0.70f, .contrast = 0.018f};
    case Scene::kMarker:
      break;
  }
  return {.texture = {}, .mean = 0.7f, .contrast = 0};
}

Shape VariantOf(const Shape& shape, int variant) {
  if (variant == 0) return shape;
  const double golden_rad = std::numbers::pi * (3 - std::sqrt(5.0));
  const Eigen::Matrix3d world_from_object =
      Eigen::AngleAxisd(std::remainder(golden_rad * variant, 2 * std::numbers::pi), Vector3d::UnitZ())
          .toRotationMatrix();
  Shape turned{.distance_m = [distance_m = shape.distance_m,
                              object_from_world = Eigen::Matrix3d(world_from_object.transpose())](const Vector3d& x) {
    return distance_m(object_from_world * x);
  }};
  for (int corner = 0; corner < 8; ++corner) {
    turned.bounds_in_world.extend(world_from_object *
                                  shape.bounds_in_world.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
  }
  return turned;
}

Material VariantOf(const Material& material, int variant) {
  constexpr std::uint32_t kSeedsApart = 1000;  // of textures that are to have nothing in common
  Material other = material;
  other.texture.seed += kSeedsApart * static_cast<std::uint32_t>(variant);
  return other;
}

}  // namespace rigcal::sim
