#include "sim_fixtures/render.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/ensure.h"
#include "core/base/random.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector3d;

constexpr float kClothRadiance = 0.002f;  ///< about 7 of 255 after the sRGB curve: a dark cloth is not black
constexpr float kWallLight = 0.9f;        ///< the walls are lit evenly
enum Layer { kObjectLayer = kObjectMesh, kTableLayer = kTableMesh, kWallLayer, kNumLayers };

/// Samples of one row that fell on one material.
struct Samples {
  std::vector<float> x, y, z;     ///< place in the frame of the material: world, or stage for the walls
  std::vector<float> nx, ny, nz;  ///< normal in the world, any length; none for the walls
  std::vector<int> column;
  std::vector<float> reflectance, light;

  void Clear() {
    for (auto* values : {&x, &y, &z, &nx, &ny, &nz}) values->clear();
    column.clear();
  }
};

struct LightInWorld {
  float x, y, z, intensity, wrap;
};

/// Irradiance of every sample by all lamps.
void Illuminate(const std::vector<LightInWorld>& lights, float ambient, Samples& samples) {
  const std::size_t count = samples.column.size();
  samples.light.assign(count, ambient);
  const float *nx = samples.nx.data(), *ny = samples.ny.data(), *nz = samples.nz.data();
  float* light = samples.light.data();
  for (const LightInWorld& lamp : lights) {
    for (std::size_t i = 0; i < count; ++i) {
      const float length = std::sqrt(nx[i] * nx[i] + ny[i] * ny[i] + nz[i] * nz[i]);
      const float cosine = (nx[i] * lamp.x + ny[i] * lamp.y + nz[i] * lamp.z) / length;
      light[i] += lamp.intensity * std::max(0.0f, (cosine + lamp.wrap) / (1 + lamp.wrap));
    }
  }
}

void Reflect(const Material& material, Samples& samples) {
  samples.reflectance.assign(samples.column.size(), material.mean);
  if (material.contrast == 0) return;
  EvaluateNoise(material.texture, {samples.x, samples.y, samples.z}, samples.reflectance);
  for (float& value : samples.reflectance) {
    value = std::clamp(material.mean + material.contrast * value, Material::kLeast, Material::kMost);
  }
}

/// Where a picture is taken from, and what is before the camera.
struct Vantage {
  const Camera& camera;
  Rigid3d cam_from_world, stage_from_world;
  const RayScene& rays;
};

void ReflectChart(const ChartMaterial& material, Samples& samples) {
  samples.reflectance.clear();
  for (std::size_t i = 0; i < samples.column.size(); ++i) {
    samples.reflectance.push_back(
        material.ReflectanceAt(Eigen::Vector3f(samples.x[i], samples.y[i], samples.z[i]).cast<double>(),
                               Eigen::Vector3f(samples.nx[i], samples.ny[i], samples.nz[i]).cast<double>()));
  }
}

/// Renders the rows of one view; one per thread.
class RowRenderer {
 public:
  RowRenderer(const Studio& studio, const Vantage& vantage, int samples_per_side)
      : studio_(studio),
        camera_(vantage.camera),
        rays_(vantage.rays),
        side_(samples_per_side),
        world_from_cam_(vantage.cam_from_world.Inverse()),
        stage_from_world_(vantage.stage_from_world) {
    PlaceSamples();
    for (const Light& lamp : studio.lights) {
      const Vector3d towards = stage_from_world_.rotation.conjugate() * lamp.towards_in_stage;
      lights_.push_back({static_cast<float>(towards.x()), static_cast<float>(towards.y()),
                         static_cast<float>(towards.z()), static_cast<float>(lamp.intensity),
                         static_cast<float>(lamp.wrap)});
    }
  }

  /// One row; only its columns [first, last) can show meshes.
  void Render(int row, int first, int last, RenderedView& out) {
    for (Samples& samples : layers_) samples.Clear();
    missed_.assign(camera_.width_px, side_ * side_);
    if (first < last) {
      MakeCornerRays(row, first, last);
      ShootRow(row, first, last);
    }
    float* radiance = out.radiance.ptr<float>(row);
    float* coverage = out.coverage.ptr<float>(row);
    const float share = 1.0f / static_cast<float>(side_ * side_);
    std::fill(radiance, radiance + camera_.width_px, 0.0f);
    for (const Layer layer : {kObjectLayer, kTableLayer}) {
      Samples& samples = layers_[layer];
      if (layer == kObjectLayer && studio_.chart) {
        ReflectChart(studio_.chart->material, samples);
      } else {
        Reflect(layer == kObjectLayer ? studio_.object : studio_.table_top, samples);
      }
      Illuminate(lights_, static_cast<float>(studio_.ambient), samples);
      for (std::size_t i = 0; i < samples.column.size(); ++i) {
        radiance[samples.column[i]] += share * samples.reflectance[i] * samples.light[i];
        coverage[samples.column[i]] += share;
      }
    }
    if (studio_.options.surroundings == Surroundings::kBlack) {
      for (int c = 0; c < camera_.width_px; ++c) radiance[c] += share * static_cast<float>(missed_[c]) * kClothRadiance;
    } else {
      AddWalls(row, radiance);
    }
  }

 private:
  /// The chart's lattice is the grid, turned by atan(1 / side_).
  void PlaceSamples() {
    const auto in_lattice = [this](int cell, int across) { return (cell + (across + 0.5) / side_) / side_; };
    for (int sy = 0; sy < side_; ++sy) {
      for (int sx = 0; sx < side_; ++sx) {
        samples_in_pixel_.emplace_back(studio_.chart ? in_lattice(sx, sy) : (sx + 0.5) / side_,
                                       studio_.chart ? in_lattice(sy, side_ - 1 - sx) : (sy + 0.5) / side_);
      }
    }
  }

  /// Directions at the pixels' corners above and below the row. Within a pixel they are interpolated linearly: at a
  /// focal length of 2000 px and k1 = 0.2 that is wrong by less than 1e-4 px.
  void MakeCornerRays(int row, int first, int last) {
    for (int edge = 0; edge < 2; ++edge) {
      corners_[edge].clear();
      for (int column = first; column <= last; ++column) {
        const auto ray = RayInCam(camera_, {column - 0.5, row - 0.5 + edge});
        Ensure(ray.has_value(), "the distortion can be inverted all over the picture");
        corners_[edge].push_back(world_from_cam_.rotation * *ray);
      }
    }
  }

  /// Where a pixel's samples of a chart begin. Were it the same place everywhere, an edge along the rows of the lattice
  /// would lie wrong by the same part of a pixel from end to end (0.1 px with nine samples, whatever the lattice).
  static Eigen::Vector2d ShiftAt(int row, int column) {
    const std::uint64_t bits = DeriveSeed(static_cast<std::uint64_t>(row), static_cast<std::uint64_t>(column));
    return {static_cast<double>(bits >> 32) * 0x1.0p-32, static_cast<double>(bits & 0xffffffffU) * 0x1.0p-32};
  }

  void ShootRow(int row, int first, int last) {
    RayPacket packet;
    std::array<int, kRayPacket> column{};
    int count = 0;
    const auto flush = [&] {
      rays_.Shoot(world_from_cam_.translation, count, packet);
      for (int i = 0; i < count; ++i) Sort(packet, i, column[i]);
      count = 0;
    };
    for (int c = first; c < last; ++c) {
      const Eigen::Vector2d shift = studio_.chart ? ShiftAt(row, c) : Eigen::Vector2d(0, 0);
      for (const Eigen::Vector2d& unshifted : samples_in_pixel_) {
        Eigen::Vector2d sample = unshifted + shift;
        if (studio_.chart) sample.array() -= sample.array().floor();
        const double b = sample.y();
        const Vector3d left = (1 - b) * corners_[0][c - first] + b * corners_[1][c - first];
        const Vector3d right = (1 - b) * corners_[0][c - first + 1] + b * corners_[1][c - first + 1];
        const Vector3d along = left + sample.x() * (right - left);
        packet.direction_x[count] = static_cast<float>(along.x());
        packet.direction_y[count] = static_cast<float>(along.y());
        packet.direction_z[count] = static_cast<float>(along.z());
        column[count++] = c;
        if (count == kRayPacket) flush();
      }
    }
    if (count > 0) flush();
  }

  /// Puts one ray's sample to its material.
  void Sort(const RayPacket& packet, int i, int column) {
    if (packet.mesh[i] == kMissed) return;
    --missed_[column];
    const Vector3d along(packet.direction_x[i], packet.direction_y[i], packet.direction_z[i]);
    const Vector3d place = world_from_cam_.translation + static_cast<double>(packet.distance[i]) * along;
    Samples& samples = layers_[packet.mesh[i]];
    samples.x.push_back(static_cast<float>(place.x()));
    samples.y.push_back(static_cast<float>(place.y()));
    samples.z.push_back(static_cast<float>(place.z()));
    samples.column.push_back(column);
    samples.nx.push_back(packet.normal_x[i]);
    samples.ny.push_back(packet.normal_y[i]);
    samples.nz.push_back(packet.normal_z[i]);
  }

  /// The walls are smooth from pixel to pixel: one sample at each pixel's centre, for all rays that met nothing else.
  void AddWalls(int row, float* radiance) {
    Samples& samples = layers_[kWallLayer];
    for (int c = 0; c < camera_.width_px; ++c) {
      if (missed_[c] == 0) continue;
      const auto ray = RayInCam(camera_, {static_cast<double>(c), static_cast<double>(row)});
      Ensure(ray.has_value(), "the distortion can be inverted all over the picture");
      const Vector3d place = WallInStage(world_from_cam_.rotation * *ray);
      samples.x.push_back(static_cast<float>(place.x()));
      samples.y.push_back(static_cast<float>(place.y()));
      samples.z.push_back(static_cast<float>(place.z()));
      samples.column.push_back(c);
    }
    Reflect(studio_.walls, samples);
    for (std::size_t i = 0; i < samples.column.size(); ++i) {
      const int c = samples.column[i];
      const float share = static_cast<float>(missed_[c]) / static_cast<float>(side_ * side_);
      radiance[c] += share * kWallLight * samples.reflectance[i];
    }
  }

  [[nodiscard]] Vector3d WallInStage(const Vector3d& along_in_world) const {
    const Vector3d origin = stage_from_world_ * world_from_cam_.translation;
    const Vector3d along = (stage_from_world_.rotation * along_in_world).normalized();
    const double half = origin.dot(along);
    const double t = -half + std::sqrt(half * half - origin.squaredNorm() + kWallRadius_m * kWallRadius_m);
    return origin + t * along;
  }

  const Studio& studio_;
  const Camera& camera_;
  const RayScene& rays_;
  int side_;
  std::vector<Eigen::Vector2d> samples_in_pixel_;  ///< from its upper left corner, in pixels
  Rigid3d world_from_cam_, stage_from_world_;
  std::vector<LightInWorld> lights_;
  std::array<std::vector<Vector3d>, 2> corners_;
  std::array<Samples, kNumLayers> layers_;
  std::vector<int> missed_;  ///< per column: rays that met no mesh
};

/// The part of the picture that can show meshes.
cv::Rect Extent(const Vantage& vantage) {
  const Camera& camera = vantage.camera;
  const cv::Rect whole(0, 0, camera.width_px, camera.height_px);
  Eigen::AlignedBox2d box;
  for (const TriangleMesh& mesh : vantage.rays.Meshes()) {
    for (const Eigen::Vector3f& x : mesh.vertices_in_world) {
      const auto x_px = Project(camera, vantage.cam_from_world * x.cast<double>());
      if (!x_px) return whole;
      box.extend(*x_px);
    }
  }
  const Eigen::Array2i low = box.min().array().floor().cast<int>() - 2;
  const Eigen::Array2i high = box.max().array().ceil().cast<int>() + 3;
  return cv::Rect(cv::Point(low.x(), low.y()), cv::Point(high.x(), high.y())) & whole;
}

Result<RenderedView> RenderFrom(const Studio& studio, const Vantage& vantage, int samples_per_side,
                                const Execution& execution) {
  Ensure(samples_per_side > 0, "at least one sample a pixel");
  constexpr int kRowsPerTask = 16;
  const Camera& camera = vantage.camera;
  RenderedView out{cv::Mat1f(camera.height_px, camera.width_px, kClothRadiance),
                   cv::Mat1f(camera.height_px, camera.width_px, 0.0f)};
  const cv::Rect extent = Extent(vantage);
  const bool walls = studio.options.surroundings == Surroundings::kBackdrop;
  const int begin = walls ? 0 : extent.y, end = walls ? camera.height_px : extent.y + extent.height;
  const int tasks = (end - begin + kRowsPerTask - 1) / kRowsPerTask;
  const bool done = ParallelFor(execution, tasks, [&](int task) {
    RowRenderer renderer(studio, vantage, samples_per_side);
    const int first = begin + task * kRowsPerTask;
    for (int row = first; row < std::min(first + kRowsPerTask, end); ++row) {
      const bool shows_meshes = row >= extent.y && row < extent.y + extent.height;
      renderer.Render(row, extent.x, shows_meshes ? extent.x + extent.width : extent.x, out);
    }
  });
  if (!done) return Cancelled("rendering");
  return out;
}

}  // namespace

Result<RenderedView> RenderView(const Studio& studio, int view, int samples_per_side, const Execution& execution) {
  Ensure(view >= 0 && view < studio.truth.NumViews(), "the view exists");
  const Vantage vantage{studio.truth.CameraOf(view), studio.truth.views[view].cam_from_world,
                        studio.stage_from_world[view], studio.rays};
  return RenderFrom(studio, vantage, samples_per_side, execution);
}

Result<RenderedView> RenderHandHeld(const Studio& studio, int index, int samples_per_side, const Execution& execution) {
  Ensure(studio.chart.has_value(), "a chart can be held");
  const HandHeldView& view = studio.chart->hand_held.at(index);
  // Rendering knows the board where it lies: world is what it was, and goes with the board into the hand.
  const Rigid3d cam_from_world = view.cam_from_board * studio.chart->world_from_board.Inverse();
  const Vantage vantage{studio.truth.cameras[view.camera], cam_from_world,
                        studio.cam_from_stage[view.camera].Inverse() * cam_from_world, studio.chart->rays_in_hand};
  return RenderFrom(studio, vantage, samples_per_side, execution);
}

}  // namespace rigcal::sim
