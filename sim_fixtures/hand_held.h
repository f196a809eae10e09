#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "sim_fixtures/chart.h"

namespace rigcal::sim {

/// A picture of the board in somebody's hand before a camera.
struct HandHeldView {
  std::string name;  ///< camC_handNN.png
  int camera = 0;
  Rigid3d cam_from_board;
};

/// options.num_hand_held pictures for each camera. The tags fill 30 to 90 % of the picture's height, tilted by up to 45
/// degrees against the line of sight in any direction; four of five have a corner of the board in one of the picture's
/// corners, in turn, the others lie about the middle. Parts may be outside of the picture.
std::vector<HandHeldView> HoldByHand(const ChartOptions& options, const std::vector<Camera>& cameras,
                                     std::uint64_t random_seed);

}  // namespace rigcal::sim
