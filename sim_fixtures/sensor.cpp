#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/ensure.h"
#include "core/base/random.h"
#include "sim_fixtures/render.h"

namespace rigcal::sim {
namespace {

/// IEC 61966-2-1.
double Srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// The curve by a table: entries every 1/4096, linear in between (wrong by less than 0.03 grey levels of 8 bit above
/// the cloth's radiance).
class ToneCurve {
 public:
  explicit ToneCurve(bool linear) : values_(kEntries + 2) {
    for (int i = 0; i < kEntries + 2; ++i) {
      const double x = static_cast<double>(i) / kEntries;
      values_[i] = static_cast<float>(linear ? x : Srgb(x));
    }
  }
  [[nodiscard]] float operator()(float radiance) const {
    const float x = std::clamp(radiance, 0.0f, 1.0f) * kEntries;
    const int i = static_cast<int>(x);
    return values_[i] + (x - static_cast<float>(i)) * (values_[i + 1] - values_[i]);
  }

 private:
  static constexpr int kEntries = 4096;
  std::vector<float> values_;
};

template <typename Value>
void ExposeRow(const float* radiance, int width, const ToneCurve& curve, double noise_sigma, Random& random,
               Value* out) {
  constexpr float kFull = static_cast<float>(std::numeric_limits<Value>::max());
  const double sigma = noise_sigma / 255.0 * static_cast<double>(kFull);
  for (int x = 0; x < width; ++x) {
    float value = curve(radiance[x]) * kFull;
    if (sigma > 0) value += static_cast<float>(sigma * random.Normal());
    out[x] = static_cast<Value>(std::clamp(value + 0.5f, 0.0f, kFull));
  }
}

}  // namespace

cv::Mat Expose(const cv::Mat1f& radiance, const SensorOptions& sensor, std::uint64_t noise_seed) {
  Ensure(sensor.bits == 8 || sensor.bits == 16, "8 or 16 bits");
  cv::Mat1f blurred = radiance;
  if (sensor.blur_sigma_px > 0) {
    const int reach = static_cast<int>(std::ceil(4 * sensor.blur_sigma_px));
    cv::GaussianBlur(radiance, blurred, cv::Size(2 * reach + 1, 2 * reach + 1), sensor.blur_sigma_px,
                     sensor.blur_sigma_px, cv::BORDER_REPLICATE);
  }
  const ToneCurve curve(sensor.linear);
  cv::Mat picture(radiance.size(), sensor.bits == 8 ? CV_8U : CV_16U);
  for (int y = 0; y < radiance.rows; ++y) {
    Random random(DeriveSeed(noise_seed, static_cast<std::uint64_t>(y)));
    if (sensor.bits == 8) {
      ExposeRow(blurred.ptr<float>(y), radiance.cols, curve, sensor.noise_sigma, random, picture.ptr<std::uint8_t>(y));
    } else {
      ExposeRow(blurred.ptr<float>(y), radiance.cols, curve, sensor.noise_sigma, random, picture.ptr<std::uint16_t>(y));
    }
  }
  return picture;
}

cv::Mat1b MaskOf(const RenderedView& view) {
  constexpr float kHalf = 0.4999f;  // sums of 1/n^2 fall short of one half by rounding
  cv::Mat1b mask;
  cv::compare(view.coverage, kHalf, mask, cv::CMP_GE);
  return mask;
}

}  // namespace rigcal::sim
