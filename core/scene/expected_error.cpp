#include "core/scene/expected_error.h"

#include <cmath>

#include "core/base/ensure.h"

namespace rigcal {

int PyramidLevel(double expected_error_px) {
  Ensure(std::isfinite(expected_error_px), "an expected error is a number");
  return expected_error_px < 1 ? 0 : static_cast<int>(std::floor(std::log2(expected_error_px)));
}

}  // namespace rigcal
