#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/base/execution.h"

namespace rigcal {

/// What the silhouettes of one physical camera's pictures were told from.
enum class Background {
  kNone,    ///< none found: everything counts as object
  kDark,    ///< a dark cloth: thresholding and morphology
  kStatic,  ///< pixels that do not change while the object turns in front of a fixed camera
};

struct Silhouettes {
  Background background = Background::kNone;
  std::vector<cv::Mat1b> masks;      ///< one per picture, 255 = object; all empty for kNone
  std::vector<double> object_share;  ///< share of each picture that is object; 1 for kNone
};

/// Silhouettes of the object in all pictures (grey, [0, 1]) of one physical camera, without being told what the
/// background is (`--masks auto`). Errs on the side of kNone: a wrong mask costs more than none. kNone when stopped.
Silhouettes FindSilhouettes(const std::vector<cv::Mat1f>& pictures, const Execution& execution);

}  // namespace rigcal
