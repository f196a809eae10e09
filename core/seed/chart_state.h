#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/scene/board.h"
#include "core/scene/board_shape.h"
#include "core/scene/chart_sighting.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/rig_model.h"

namespace rigcal {

/// How the board lies on the table: tilts about world x and y (rad), x and y of its origin (m). Its turn about z and
/// its height (the board's thickness) define the world's x axis and z = 0; positioners that are no turntable leave the
/// world to the board altogether: all zero.
inline constexpr int kBoardPlaceSize = 4;
using BoardPlace = std::array<double, kBoardPlaceSize>;
Rigid3d WorldFromBoard(const BoardPlace& place, double thickness_m);

/// The corners that one view contributes.
struct ChartView {
  int camera = 0;
  std::optional<int> stop;  ///< the rig model gives the pose; otherwise ChartState::cam_from_board
  std::vector<ChartCorner> corners;
};

/// The unknowns of seeding.
struct ChartState {
  std::vector<Camera> cameras;
  BoardShape shape;
  BoardPlace place = {};
  RigModel rig;
  std::vector<StopError> stop_errors;
  std::vector<Rigid3d> cam_from_board;  ///< per view; of those without a stop
};

/// What they are estimated from.
struct ChartTerms {
  Board board;
  std::vector<ChartView> views;  ///< per view of the scene; empty where nothing is used
  std::vector<StopPosition> stops;
  std::vector<StopError> stop_error_sigma;  ///< per stop: the prior; 0: held at zero
  std::vector<double> noise_scale;          ///< per camera: sigma of a corner over the stated one
  std::vector<bool> uses_k3;                ///< per camera
  double bow_sigma_m = 0, stretch_sigma = 0;
};

/// cam_from_board of a view.
Rigid3d CamFromBoard(const ChartTerms& terms, const ChartState& state, int view);

}  // namespace rigcal
