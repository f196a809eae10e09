#include "drivers/driver.h"

#include <cmath>
#include <limits>

namespace rigcal {

Result<void> CheckTarget(const StopTarget& target, const std::vector<AxisSettings>& axes, const std::string& device) {
  if (target.axes.size() != axes.size()) {
    return Fail(ErrorCode::kBadInput, "{}: stop '{}' has {} values, the machine has {} axes", device, target.id,
                target.axes.size(), axes.size());
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const char* unit = axes[i].unit == AxisUnit::kRadian ? "rad" : "m";
    const double value = target.axes[i];
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const double least = axes[i].least.value_or(-kNone), most = axes[i].most.value_or(kNone);
    if (!std::isfinite(value) || value < least || value > most) {
      return Fail(ErrorCode::kBadInput, "{}: stop '{}': axis '{}' is to go to {} {}, its limits are {} .. {}", device,
                  target.id, axes[i].name, value, unit, least, most);
    }
  }
  return {};
}

}  // namespace rigcal
