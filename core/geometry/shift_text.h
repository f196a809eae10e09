#pragma once

#include <Eigen/Core>
#include <string>

namespace rigcal {

/// "0.41 right, 0.12 down": a shift in the picture, in pixels (+x right, +y down).
std::string ShiftText(const Eigen::Vector2d& shift_px);

}  // namespace rigcal
