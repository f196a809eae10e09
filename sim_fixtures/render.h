#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "sim_fixtures/studio.h"

namespace rigcal::sim {

/// What reaches the sensor, before lens and electronics.
struct RenderedView {
  cv::Mat1f radiance;  ///< linear; 1 is full scale
  cv::Mat1f coverage;  ///< share of the pixel's samples that met the object or the table top
};

/// samples_per_side^2 rays a pixel on a regular grid (a box filter over the pixel); for a chart on a turned
/// grid that begins elsewhere in each pixel: its edges then lie right on the average along them, in any direction.
/// Errors: kCancelled.
Result<RenderedView> RenderView(const Studio& studio, int view, int samples_per_side, const Execution& execution);

/// The same of the studio's chart in the hand: Chart::hand_held[index]. Lamps and walls are where they are.
Result<RenderedView> RenderHandHeld(const Studio& studio, int index, int samples_per_side, const Execution& execution);

/// Lens and electronics.
struct SensorOptions {
  double blur_sigma_px = 0.5;  ///< Gaussian point spread of the lens
  double noise_sigma = 1.0;    ///< of the recorded values, in grey levels of 8 bit
  bool linear = false;         ///< recorded values proportional to the light; otherwise the sRGB curve
  int bits = 8;                ///< 8 or 16
};

/// The recorded picture, CV_8U or CV_16U. The noise depends on noise_seed and the pixel alone.
cv::Mat Expose(const cv::Mat1f& radiance, const SensorOptions& sensor, std::uint64_t noise_seed);

/// 255 where at least half of the pixel is object.
cv::Mat1b MaskOf(const RenderedView& view);

}  // namespace rigcal::sim
