#include "sim_fixtures/placement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "sim_fixtures/stop_error.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector3d;

constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kHorizontalView_rad = 28 * kRadPerDeg;
/// Share of the half picture that the object may reach to, in height and width.
constexpr double kFilledHeight = 0.84, kFilledWidth = 0.88;
constexpr double kSingleElevation_deg = 18, kLowestElevation_deg = 8, kHighestElevation_deg = 48;
constexpr double kCameraSpacing_deg = 9;  ///< azimuth between the cameras of one turntable
constexpr std::uint64_t kBumpTask = 40;   ///< DeriveSeed: + camera

/// Direction of the camera seen from the object, and its roll.
struct Aim {
  double azimuth_rad = 0, elevation_rad = 0, roll_rad = 0;
};

/// Cameras differ a little from each other, as bought ones do, and their principal points are off centre.
Camera MakeCamera(const StudioOptions& options, int index) {
  Camera camera;
  camera.id = camera.physical_id = fmt::format("cam{}", index);
  camera.width_px = options.width_px;
  camera.height_px = options.height_px;
  const double w = options.width_px, h = options.height_px;
  const double ideal_px = 0.5 * std::max(w, h) / std::tan(0.5 * kHorizontalView_rad);
  camera.fx_px = camera.fy_px = ideal_px * (1 + 0.012 * std::sin(2.0 * index + 0.5));
  camera.cx_px = 0.5 * (w - 1) + 0.008 * w * std::cos(2.3 * index + 0.4);
  camera.cy_px = 0.5 * (h - 1) - 0.009 * h * std::cos(1.7 * index + 0.9);
  camera.k1 = options.distortion[0], camera.k2 = options.distortion[1];
  camera.p1 = options.distortion[2], camera.p2 = options.distortion[3], camera.k3 = options.distortion[4];
  return camera;
}

Rigid3d CamFromStage(const Aim& aim, const Vector3d& target_in_stage, double distance_m) {
  const Vector3d outward(std::cos(aim.elevation_rad) * std::cos(aim.azimuth_rad),
                         std::cos(aim.elevation_rad) * std::sin(aim.azimuth_rad), std::sin(aim.elevation_rad));
  const Vector3d forward = -outward;
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rows;
  rows << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  const Eigen::Quaterniond level(rows);
  const Eigen::Quaterniond rotation = (ExpRotation({0, 0, aim.roll_rad}) * level).normalized();
  return {rotation, -(rotation * (target_in_stage + distance_m * outward))};
}

/// The least distance from which all points lie within the filled part of the picture.
double FittingDistance(const Camera& camera, const Aim& aim, const Vector3d& target,
                       std::span<const Vector3d> points_in_stage) {
  const auto fits = [&](double distance_m) {
    const Rigid3d cam_from_stage = CamFromStage(aim, target, distance_m);
    return std::all_of(points_in_stage.begin(), points_in_stage.end(), [&](const Vector3d& x) {
      const auto x_px = Project(Undistorted(camera), cam_from_stage * x);
      return x_px && std::abs(x_px->x() - camera.cx_px) < 0.5 * kFilledWidth * camera.width_px &&
             std::abs(x_px->y() - camera.cy_px) < 0.5 * kFilledHeight * camera.height_px;
    });
  };
  double near_m = 0.1, far_m = 1.4;
  for (int i = 0; i < 40; ++i) {
    const double middle_m = 0.5 * (near_m + far_m);
    (fits(middle_m) ? far_m : near_m) = middle_m;
  }
  return far_m;
}

/// Points that bound the object however the table is turned: its radius at every height, all round.
std::vector<Vector3d> SweptOutline(std::span<const Eigen::Vector3f> surface, double height_m) {
  constexpr int kSlices = 24, kAround = 24;
  std::vector<double> radius_m(kSlices, 0.0);
  for (const Eigen::Vector3f& x : surface) {
    const int slice = std::clamp(static_cast<int>(x.z() / height_m * kSlices), 0, kSlices - 1);
    radius_m[slice] = std::max(radius_m[slice], static_cast<double>(std::hypot(x.x(), x.y())));
  }
  std::vector<Vector3d> outline;
  for (int slice = 0; slice < kSlices; ++slice) {
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      for (int end = 0; end < 2; ++end) {
        outline.emplace_back(radius_m[slice] * std::cos(angle), radius_m[slice] * std::sin(angle),
                             height_m * (slice + end) / kSlices);
      }
    }
  }
  return outline;
}

/// The camera turns about its own centre, as on the head of its tripod.
Rigid3d TurnedBy(const Vector3d& turn_rad, const Rigid3d& cam_from_stage) {
  return Rigid3d{ExpRotation(turn_rad), Vector3d::Zero()} * cam_from_stage;
}

/// Mean shift of the pictures of the outline.
double MeanShift_px(const Camera& camera, const Rigid3d& before, const Rigid3d& after,
                    std::span<const Vector3d> outline) {
  double sum_px = 0;
  int count = 0;
  for (const Vector3d& x : outline) {
    const auto a_px = Project(Undistorted(camera), before * x), b_px = Project(Undistorted(camera), after * x);
    if (!a_px || !b_px) continue;
    sum_px += (*b_px - *a_px).norm();
    ++count;
  }
  return sum_px / std::max(1, count);
}

/// With the faults of its mount. `index` is the camera's.
Rigid3d Bumped(const StudioOptions& options, int index, const Camera& camera, std::span<const Vector3d> outline,
               Rigid3d cam_from_stage) {
  Random random(DeriveSeed(options.random_seed, kBumpTask + static_cast<std::uint64_t>(index)));
  const double x = random.Normal(), y = random.Normal(), z = random.Normal();
  const Vector3d axis_in_cam = Vector3d(x, y, z).normalized();
  for (const Fault& bump : options.bumps) {
    if (bump.index == index) cam_from_stage = TurnedBy(bump.angle_deg * kRadPerDeg * axis_in_cam, cam_from_stage);
  }
  for (const PixelBump& bump : options.pixel_bumps) {
    if (bump.index != index) continue;
    constexpr double kTrial_rad = 1e-4;  // so little that the shift grows with the angle
    const double trial_px =
        MeanShift_px(camera, cam_from_stage, TurnedBy(kTrial_rad * axis_in_cam, cam_from_stage), outline);
    cam_from_stage = TurnedBy(kTrial_rad * bump.shift_px / trial_px * axis_in_cam, cam_from_stage);
  }
  return cam_from_stage;
}

void AddView(Placement& placement, std::string name, int camera, int stop, const Rigid3d& stage_from_world,
             double angle_rad, const Rigid3d& cam_from_stage) {
  placement.truth.views.push_back({std::move(name), camera, cam_from_stage * stage_from_world});
  placement.stage_from_world.push_back(stage_from_world);
  placement.table_angle_rad.push_back(angle_rad);
  placement.stop.push_back(stop);
}

void PlaceAtTurntable(const StudioOptions& options, const Vector3d& target, std::span<const Vector3d> outline,
                      Placement& placement) {
  placement.stop_errors = DrawStopErrors(options);
  for (int stop = 0; stop < options.num_stops; ++stop) {
    placement.commanded_rad.push_back(2 * std::numbers::pi * stop / options.num_stops);
  }
  const int digits = options.num_stops > 100 ? 3 : 2;
  for (int c = 0; c < options.num_cameras; ++c) {
    placement.truth.cameras.push_back(MakeCamera(options, c));
    const double share = options.num_cameras == 1 ? 0 : c / (options.num_cameras - 1.0);
    const double elevation_deg = options.num_cameras == 1
                                     ? kSingleElevation_deg
                                     : kLowestElevation_deg + share * (kHighestElevation_deg - kLowestElevation_deg);
    const double azimuth_deg = -90 + kCameraSpacing_deg * (c - 0.5 * (options.num_cameras - 1));
    const Aim aim{azimuth_deg * kRadPerDeg, elevation_deg * kRadPerDeg, 1.5 * kRadPerDeg * std::cos(2.0 * c + 1)};
    const double distance_m = FittingDistance(placement.truth.cameras[c], aim, target, outline);
    const Rigid3d cam_from_stage =
        Bumped(options, c, placement.truth.cameras[c], outline, CamFromStage(aim, target, distance_m));
    placement.cam_from_stage.push_back(cam_from_stage);
    for (int stop = 0; stop < options.num_stops; ++stop) {
      const StopError& error = placement.stop_errors[stop];
      AddView(placement, fmt::format("cam{}_stop{:0{}}.png", c, stop, digits), c, stop,
              StageFromWorld(placement.commanded_rad[stop], error), placement.commanded_rad[stop] + error[kStep],
              cam_from_stage);
    }
  }
}

void PlaceOnGantry(const StudioOptions& options, const Vector3d& target, std::span<const Vector3d> outline,
                   Placement& placement) {
  const double golden_rad = std::numbers::pi * (3 - std::sqrt(5.0));
  constexpr double kLowestSine = 0.10, kHighestSine = 0.92;  // of the elevation: 6 to 67 degrees
  placement.truth.cameras.push_back(MakeCamera(options, 0));
  std::vector<Aim> aims;
  double distance_m = 0;
  for (int i = 0; i < options.num_views; ++i) {
    const double sine = kLowestSine + (kHighestSine - kLowestSine) * (i + 0.5) / options.num_views;
    aims.push_back({golden_rad * i, std::asin(sine), 2 * kRadPerDeg * std::sin(3.0 * i)});
    distance_m = std::max(distance_m, FittingDistance(placement.truth.cameras[0], aims.back(), target, outline));
  }
  const int digits = options.num_views > 100 ? 3 : 2;
  for (int i = 0; i < options.num_views; ++i) {
    AddView(placement, fmt::format("cam0_view{:0{}}.png", i, digits), 0, i, Rigid3d(), 0,
            CamFromStage(aims[i], target, distance_m));
  }
  placement.cam_from_stage.push_back(CamFromStage(aims.front(), target, distance_m));
}

}  // namespace

Placement PlaceCameras(const StudioOptions& options, std::span<const Eigen::Vector3f> surface_in_world) {
  float height_m = 0;
  for (const Eigen::Vector3f& x : surface_in_world) height_m = std::max(height_m, x.z());
  const std::vector<Vector3d> outline = SweptOutline(surface_in_world, height_m);
  const Vector3d target(0, 0, 0.5 * height_m);
  Placement placement;
  placement.truth.unit = LengthUnit::kMetre;
  if (options.motion == Motion::kTurntable) {
    PlaceAtTurntable(options, target, outline, placement);
  } else {
    PlaceOnGantry(options, target, outline, placement);
  }
  return placement;
}

}  // namespace rigcal::sim
