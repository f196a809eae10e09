#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/execution.h"
#include "core/scene/board.h"
#include "core/scene/board_shape.h"
#include "core/scene/chart_sighting.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/rig_estimate.h"

namespace rigcal {

/// A physical camera before anything is known of its lens.
struct SeedCamera {
  std::string id;
  int width_px = 0, height_px = 0;
};

/// A picture of the chart. Without a stop (a board held by hand) its pose is its own.
struct SeedView {
  std::string name;
  int camera = 0;
  std::optional<int> stop;  ///< index into SeedScene::stops
};

/// What seeding works on. At the stops the board lies still in the world (on the table, say); the rig model says how
/// the positioner moves it or the cameras. Without a rig model every view's pose is its own.
struct SeedScene {
  std::vector<SeedCamera> cameras;
  std::vector<SeedView> views;
  std::vector<StopPosition> stops;
  std::vector<ChartSighting> sightings;  ///< at most one per view; views without one saw nothing
  Board board;
  std::optional<RigModel> rig;
};

struct SeedOptions {
  double max_rms_px = 0.5;    ///< above it a calibration is refused (issue 3)
  double huber_sigmas = 3;    ///< robust loss of a corner, in sigmas found from the residuals: keeps 99 % of good ones
  double bow_sigma_m = 3e-4;  ///< prior: "the chart was flat only to a tenth of a millimetre" (DESIGN.md section 1)
  double stretch_sigma = 1e-3;      ///< prior on the print's anisotropy: a millimetre in a metre, as printers do
  int min_corners_per_view = 8;     ///< two tags; a view with fewer is left out
  int min_views_per_camera = 3;     ///< Zhang's least number for all intrinsics of a planar board
  double contradiction_sigmas = 5;  ///< a stop or camera further than this from the rig model contradicts it
};

/// A view whose pose is its own: a board held by hand, or a view that contradicts the rig model.
struct HandHeldPose {
  int view = 0;
  Rigid3d cam_from_board;
  Eigen::Matrix<double, 6, 6> covariance;  ///< of Disturbed()
};

/// The turntable's axis as the board on it has it, free of the errors of any lens. Sigmas: one component.
struct AxisOnBoard {
  Eigen::Vector3d direction_in_board = Eigen::Vector3d::UnitZ();
  Eigen::Vector2d point_in_board = Eigen::Vector2d::Zero();  ///< where it goes through the plane of the print, metres
  double direction_sigma_rad = 0, point_sigma_m = 0;
};

/// How well a camera's picture and its lens are determined.
struct SeedCameraReport {
  int num_views = 0, num_corners = 0, num_outliers = 0;
  double rms_px = 0;       ///< root mean square of one corner's distance
  double noise_scale = 0;  ///< sigma of a corner over the sigma that its detector stated
  bool uses_k3 = false;
  double k3_gain = 0;  ///< chi-square gained by k3, against k3_cost (Schwarz's criterion)
  double k3_cost = 0;
  double coverage = 0;      ///< share of the picture's cells that corners fell into
  double max_tilt_rad = 0;  ///< largest angle between the board's normal and the line of sight
};

struct SeedReport {
  int num_iterations = 0;
  double rms_px = 0;
  std::vector<SeedCameraReport> cameras;
  std::vector<double> view_rms_px;          ///< per view; 0 where nothing was used
  std::vector<std::string> advice;          ///< what to show next
  std::vector<std::string> contradictions;  ///< where the pictures and the rig model disagree, and who is at fault
};

struct SeedResult {
  /// Metres. Views at the stops of the rig (all of a camera whose mount is known, whether it saw the chart or not) in
  /// the table's world; without a rig all views that saw the chart, world = board. With covariance and, where the model
  /// holds, the rig.
  RigCalibration calibration;
  std::vector<int> view_of;  ///< per view of the calibration: index into SeedScene::views
  std::vector<HandHeldPose> hand_held;
  BoardShape board_shape;
  BoardShape board_shape_sigma;
  std::optional<RigFit> rig;                 ///< together with calibration.rig
  Rigid3d world_from_board;                  ///< with a rig
  std::optional<AxisOnBoard> axis_on_board;  ///< of a turntable that was found
  SeedReport report;
};

/// Calibrates every camera and the rig from pictures of the chart, in one adjustment. Errors: kBadInput with the camera
/// or view concerned when there is too little to see or the residuals are above max_rms_px; kCancelled.
Result<SeedResult> SeedCameras(const SeedScene& scene, const SeedOptions& options, const Execution& execution);

}  // namespace rigcal
