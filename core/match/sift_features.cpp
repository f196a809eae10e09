#include "core/match/sift_features.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

namespace rigcal {
namespace {

/// Larger pictures cost more and match no better: the features only start a refinement.
constexpr int kMaxSidePx = 1600;
/// OpenCV 4.6 doubles the picture by cv::resize before it looks for features, and does not undo the quarter of a pixel
/// by which that shifts everything (tests/match/sift_features_test.cpp measures it).
constexpr double kOpenCvShiftPx = 0.25;
/// cv::KeyPoint::size is the diameter, 2 sigma.
constexpr double kSigmaPerSize = 0.5;
/// Half of OpenCV's default: plaster and skin have little contrast, and the mask keeps the background out.
constexpr double kContrastThreshold = 0.02;
constexpr int kLayersPerOctave = 3;    // Lowe, IJCV 2004
constexpr double kEdgeThreshold = 10;  // Lowe, IJCV 2004
constexpr double kFirstSigma = 1.6;    // Lowe, IJCV 2004

int WorkingLevel(const ViewImages& view) {
  int level = 0;
  while (level + 1 < static_cast<int>(view.gray.size()) &&
         std::max(view.gray[level].cols, view.gray[level].rows) > kMaxSidePx) {
    ++level;
  }
  return level;
}

/// Around the object, pixels of the working level: the windows of the descriptors of common scales fit.
constexpr int kMarginPx = 48;

/// The part of the level's picture that shows the object: most of a studio's picture is background.
cv::Rect ObjectBox(const ViewImages& view, int level) {
  const cv::Rect all({0, 0}, view.gray[level].size());
  if (view.mask.empty()) return all;
  const cv::Rect box = cv::boundingRect(view.mask >= kMaskThreshold);
  const cv::Point first(box.x >> level, box.y >> level), margin(kMarginPx, kMarginPx);
  const cv::Point end((box.br().x >> level) + 1, (box.br().y >> level) + 1);
  return box.empty() ? box : cv::Rect(first - margin, end + margin) & all;
}

/// Stretched so that the brightest pixel is white: OpenCV's SIFT takes bytes only, and a dark picture would lose its
/// texture to rounding.
cv::Mat1b AsBytes(const cv::Mat1f& image) {
  double max = 0;
  cv::minMaxLoc(image, nullptr, &max);
  cv::Mat1b bytes;
  image.convertTo(bytes, CV_8U, max > 0 ? 255 / max : 255);
  return bytes;
}

/// A total order, so that neither the number of OpenCV's threads nor a library's sort decides which features are kept.
bool Stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return std::make_tuple(-a.response, a.pt.x, a.pt.y, a.size, a.angle, a.octave) <
         std::make_tuple(-b.response, b.pt.x, b.pt.y, b.size, b.angle, b.octave);
}

Eigen::MatrixXf RootSift(const cv::Mat1f& sift) {
  Eigen::MatrixXf d(sift.cols, sift.rows);
  for (int i = 0; i < sift.rows; ++i) {
    const Eigen::Map<const Eigen::VectorXf> histogram(sift.ptr<float>(i), sift.cols);
    d.col(i) = (histogram / std::max(histogram.lpNorm<1>(), 1e-6f)).cwiseSqrt();
  }
  return d;
}

void NumberPlaces(SiftFeatures& features) {
  std::vector<int> order(features.x_px.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const auto position = [&](int i) { return std::make_pair(features.x_px[i].x(), features.x_px[i].y()); };
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return std::make_pair(position(a), a) < std::make_pair(position(b), b); });
  features.place.assign(order.size(), 0);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k == 0 || position(order[k]) != position(order[k - 1])) ++features.num_places;
    features.place[order[k]] = features.num_places - 1;
  }
}

}  // namespace

SiftFeatures FindSiftFeatures(const ViewImages& view, int max_features) {
  const int level = WorkingLevel(view);
  const cv::Rect box = ObjectBox(view, level);
  SiftFeatures features;
  if (box.empty()) return features;
  const double full_per_level = std::ldexp(1.0, level);
  const auto full_size = [&](const cv::KeyPoint& k) {
    return Eigen::Vector2d(full_per_level * (box.x + static_cast<double>(k.pt.x) - kOpenCvShiftPx),
                           full_per_level * (box.y + static_cast<double>(k.pt.y) - kOpenCvShiftPx));
  };
  constexpr int kAll = 0;
  const auto sift = cv::SIFT::create(kAll, kLayersPerOctave, kContrastThreshold, kEdgeThreshold, kFirstSigma);
  const cv::Mat1b bytes = AsBytes(view.gray[level](box));
  std::vector<cv::KeyPoint> found;
  sift->detect(bytes, found);
  std::erase_if(found, [&](const cv::KeyPoint& k) { return !view.IsObject(full_size(k)); });
  std::sort(found.begin(), found.end(), Stronger);
  if (static_cast<int>(found.size()) > max_features) found.resize(static_cast<std::size_t>(max_features));

  if (found.empty()) return features;
  cv::Mat descriptors;
  sift->compute(bytes, found, descriptors);
  features.descriptors = RootSift(descriptors);
  for (const cv::KeyPoint& k : found) {
    features.x_px.push_back(full_size(k));
    features.scale_px.push_back(full_per_level * kSigmaPerSize * static_cast<double>(k.size));
  }
  NumberPlaces(features);
  return features;
}

std::optional<std::vector<SiftFeatures>> FindSiftFeatures(const ImageSet& images, int max_features,
                                                          const Execution& execution) {
  std::vector<SiftFeatures> features(images.views.size());
  const bool finished = ParallelFor(execution, images.NumViews(),
                                    [&](int v) { features[v] = FindSiftFeatures(images.views[v], max_features); });
  if (!finished) return std::nullopt;
  return features;
}

}  // namespace rigcal
