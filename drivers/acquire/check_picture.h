#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/scene/rig_devices.h"

namespace rigcal {

struct PictureQuality {
  double saturated = 0;   ///< share of the pixels from kSaturatedGray (core/image/exposure.h) on, of any channel
  double brightness = 0;  ///< mean of the brightest hundredth of the pixels, share of full scale
  /// Mean square of the Laplacian at half size by the variance there: what blur takes away, whatever the contrast. Half
  /// size, because at full size it would be that of the noise. 0 without any contrast.
  double sharpness = 0;
};

/// 8 or 16 bits, 1 or 3 channels; of colours the brightest channel counts.
PictureQuality MeasurePicture(const cv::Mat& pixels);

/// Judges the pictures of one camera, each against the last good one.
class PictureCheck {
 public:
  explicit PictureCheck(const CaptureSettings& settings) : settings_(settings) {}

  /// What is wrong with a picture, with number and limit; nothing when it is good, and it is the last good one then.
  std::optional<std::string> Judge(const cv::Mat& pixels);

 private:
  CaptureSettings settings_;
  cv::Mat last_good_;
  double last_sharpness_ = 0;
};

}  // namespace rigcal
