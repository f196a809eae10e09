#include "core/mvs/features.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <tuple>

namespace rigcal::stereo {
namespace {

/// The PMVS paper takes 4 in blocks of 32 pixels at full size; small levels need them as dense in relation to the
/// object.
constexpr int kBlockPx = 16;
constexpr std::size_t kFeaturesPerBlock = 4;
constexpr double kHarrisSigmaPx = 1.0, kHarrisIntegrationSigmaPx = 1.5, kHarrisK = 0.06;  // PMVS paper: k = 0.06
constexpr double kFineSigmaPx = 1.0, kCoarseSigmaPx = 1.4142;  // PMVS paper: sigma_0 = 1 px, ratio sqrt(2)

cv::Mat1f HarrisResponse(const cv::Mat1f& image) {
  cv::Mat1f smooth, dx, dy, dxx, dyy, dxy;
  cv::GaussianBlur(image, smooth, {}, kHarrisSigmaPx);
  cv::Sobel(smooth, dx, CV_32F, 1, 0);
  cv::Sobel(smooth, dy, CV_32F, 0, 1);
  cv::GaussianBlur(dx.mul(dx), dxx, {}, kHarrisIntegrationSigmaPx);
  cv::GaussianBlur(dy.mul(dy), dyy, {}, kHarrisIntegrationSigmaPx);
  cv::GaussianBlur(dx.mul(dy), dxy, {}, kHarrisIntegrationSigmaPx);
  const cv::Mat trace = dxx + dyy;
  return cv::Mat(dxx.mul(dyy) - dxy.mul(dxy) - kHarrisK * trace.mul(trace));
}

cv::Mat1f BlobResponse(const cv::Mat1f& image) {
  cv::Mat1f fine, coarse;
  cv::GaussianBlur(image, fine, {}, kFineSigmaPx);
  cv::GaussianBlur(image, coarse, {}, kCoarseSigmaPx);
  return cv::Mat(cv::abs(coarse - fine));
}

/// Local maxima (3x3) of a response, the strongest of each block.
void AddMaxima(const StereoScene& scene, int view, const cv::Mat1f& response, std::vector<Feature>& features) {
  struct Maximum {
    float strength;
    Feature at;
  };
  const int border = scene.options.window_px / 2 + 1;
  for (int block_v = border; block_v < response.rows - border; block_v += kBlockPx) {
    for (int block_u = border; block_u < response.cols - border; block_u += kBlockPx) {
      std::vector<Maximum> maxima;
      for (int v = block_v; v < std::min(block_v + kBlockPx, response.rows - border); ++v) {
        for (int u = block_u; u < std::min(block_u + kBlockPx, response.cols - border); ++u) {
          const float r = response(v, u);
          if (!(r > 0) || r < response(v, u - 1) || r <= response(v, u + 1) || r < response(v - 1, u) ||
              r <= response(v + 1, u)) {
            continue;
          }
          if (scene.CanHoldWindow(view, {u, v})) maxima.push_back({r, {u, v}});
        }
      }
      const std::size_t kept = std::min(maxima.size(), kFeaturesPerBlock);
      std::partial_sort(maxima.begin(), maxima.begin() + static_cast<std::ptrdiff_t>(kept), maxima.end(),
                        [](const Maximum& a, const Maximum& b) {
                          return std::tie(b.strength, a.at.v_px, a.at.u_px) <
                                 std::tie(a.strength, b.at.v_px, b.at.u_px);
                        });
      for (std::size_t i = 0; i < kept; ++i) features.push_back(maxima[i].at);
    }
  }
}

}  // namespace

std::vector<Feature> FindFeatures(const StereoScene& scene, int view) {
  std::vector<Feature> features;
  const cv::Mat1f& image = scene.views[view].full_size->gray[scene.options.level];
  AddMaxima(scene, view, HarrisResponse(image), features);
  AddMaxima(scene, view, BlobResponse(image), features);
  const auto key = [](const Feature& f) { return std::pair(f.v_px, f.u_px); };
  std::sort(features.begin(), features.end(), [&](const Feature& a, const Feature& b) { return key(a) < key(b); });
  features.erase(std::unique(features.begin(), features.end(),
                             [&](const Feature& a, const Feature& b) { return key(a) == key(b); }),
                 features.end());
  return features;
}

}  // namespace rigcal::stereo
