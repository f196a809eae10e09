#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace rigcal {

/// One camera in one drift check.
struct NightlyShift {
  std::string camera;
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d sigma_px = Eigen::Vector2d::Zero();  ///< of each component
};

struct DriftNight {
  double time_days = 0;  ///< when it was recorded, from any origin that all nights share
  std::vector<NightlyShift> cameras;
};

/// How a camera creeps: the slope of the line through its shifts.
struct CameraTrend {
  std::string camera;
  int num_nights = 0;
  Eigen::Vector2d px_per_day = Eigen::Vector2d::Zero();  ///< +x right, +y down
  Eigen::Vector2d sigma_px_per_day = Eigen::Vector2d::Zero();
};

/// Weighted least squares, each component for itself. All nights must have been judged against one calibration: another
/// one in force begins another history. Sigmas that contain an error all nights share (that calibration's own) make the
/// slope's sigma too large, never too small. In the order of the cameras' first nights; cameras with fewer than two
/// nights at different times, or with a sigma that is not positive, have no trend.
std::vector<CameraTrend> TrendOf(const std::vector<DriftNight>& nights);

}  // namespace rigcal
