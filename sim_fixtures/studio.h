#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/execution.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/rig_model.h"
#include "sim_fixtures/chart.h"
#include "sim_fixtures/hand_held.h"
#include "sim_fixtures/ray_scene.h"
#include "sim_fixtures/shape.h"

namespace rigcal::sim {

enum class Motion {
  kTurntable,  ///< the object turns under fixed lights before fixed cameras
  kGantry,     ///< one camera moves about a fixed object under fixed lights
};
enum class Surroundings {
  kBlack,     ///< nothing but a dark cloth
  kBackdrop,  ///< textured walls that stay with the studio, and a textured table top that turns with the object
};

std::optional<Motion> MotionFromName(std::string_view name);
std::string_view NameOf(Motion motion);
std::optional<Surroundings> SurroundingsFromName(std::string_view name);
std::string_view NameOf(Surroundings surroundings);

/// Something that stands otherwise than the rig says.
struct Fault {
  int index = 0;
  double angle_deg = 0;
};

/// A camera that is turned about a random axis through itself until the pictures of the scene's object have moved by
/// so much on average, wherever on the object.
struct PixelBump {
  int index = 0;
  double shift_px = 0;
};

/// Everything that decides what is in front of the cameras and where they are.
struct StudioOptions {
  Scene scene = Scene::kTextured;
  Motion motion = Motion::kTurntable;
  Surroundings surroundings = Surroundings::kBlack;
  int num_cameras = 1;  ///< turntable only
  int num_stops = 24;   ///< turntable only
  int num_views = 20;   ///< gantry only
  int width_px = 1280;
  int height_px = 960;
  std::array<double, 5> distortion{};  ///< k1 k2 p1 p2 k3 of every camera
  double step_error_deg = 0;           ///< standard deviation of the table's angles about their nominal values
  double wobble_deg = 0;               ///< the same of the table's tilt at a stop, about each of x and y
  double run_out_mm = 0;               ///< the same of its shift, along each of x and y
  std::optional<Scene> object;         ///< this one's object on the table, under the cameras of `scene`
  int object_variant = 0;              ///< 0: as it is; else with another texture, turned about the axis
  std::vector<Fault> bumps;            ///< cameras whose mounts are turned about themselves
  std::vector<PixelBump> pixel_bumps;  ///< the same, by what the turn does to the pictures
  std::vector<Fault> slips;            ///< stops at which the table has turned too far
  std::optional<ChartOptions>
      chart;                      ///< on the table instead of the scene's object, which still decides where cameras are
  std::uint64_t random_seed = 1;  ///< draws all errors, axes of bumps, and how the chart lies and is held
  double cell_m = 0.00075;        ///< grid of the surface: three pixels of a one-megapixel picture
};

/// The limits of StudioOptions: named in messages.
inline constexpr int kMaxCameras = 16, kMaxViews = 720, kMinSide_px = 64, kMaxSide_px = 8192;
inline constexpr double kMaxStepError_deg = 5, kMaxWobble_deg = 5, kMaxRunOut_mm = 10;
inline constexpr double kMaxBump_deg = 20, kMaxPixelBump_px = 100, kMaxSlip_deg = 180;
inline constexpr double kMaxBow_mm = 10, kMaxStretch = 0.05, kMaxBoardTilt_deg = 60;
inline constexpr int kMaxHandHeld = 200, kMaxObjectVariant = 1000000;

/// A lamp far away, made soft by letting its light reach round the edge.
struct Light {
  Eigen::Vector3d towards_in_stage;  ///< unit
  double intensity = 0;
  double wrap = 0;  ///< 0: Lambert; 1: light reaches the opposite pole
};

/// The board on the table, and in the hand.
struct Chart {
  Rigid3d world_from_board;
  ChartMaterial material;
  std::vector<HandHeldView> hand_held;
  RayScene rays_in_hand;  ///< the board alone, where world_from_board has it
};

/// The studio with the object in it and the true cameras. World = the table top; stage = the studio.
struct Studio {
  StudioOptions options;
  RigCalibration truth;                   ///< metres; views named camC_stopSS.png or cam0_viewVV.png
  std::vector<Rigid3d> stage_from_world;  ///< per view; the inverse of the table's turn
  std::vector<double> table_angle_rad;    ///< per view; 0 for a gantry
  std::vector<int> stop;                  ///< per view; a gantry stops for each view
  std::vector<double> commanded_rad;      ///< per stop of a turntable: its angle without step error
  std::vector<StopError> stop_errors;     ///< per stop of a turntable
  std::vector<Rigid3d> cam_from_stage;    ///< per camera; of a gantry's at its first stop
  std::vector<Light> lights;
  double ambient = 0;
  Material object, table_top, walls;
  double table_radius_m = 0;
  std::optional<Chart> chart;
  RayScene rays;  ///< kObjectMesh (object or chart), and with a backdrop kTableMesh
};
inline constexpr int kObjectMesh = 0, kTableMesh = 1;
inline constexpr double kWallRadius_m = 1.6;  ///< the walls are a sphere about the stage's origin

/// Errors: kBadInput for options out of range, kCancelled.
Result<Studio> MakeStudio(const StudioOptions& options, const Execution& execution);

}  // namespace rigcal::sim
