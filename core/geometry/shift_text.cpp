#include "core/geometry/shift_text.h"

#include <fmt/format.h>

#include <cmath>

namespace rigcal {

std::string ShiftText(const Eigen::Vector2d& shift_px) {
  return fmt::format("{:.2f} {}, {:.2f} {}", std::abs(shift_px.x()), shift_px.x() < 0 ? "left" : "right",
                     std::abs(shift_px.y()), shift_px.y() < 0 ? "up" : "down");
}

}  // namespace rigcal
