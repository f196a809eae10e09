#include "core/match/sift_features.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rigcal {
namespace {

/// Bright Gaussian blobs on a grid, at fractions of a pixel that differ from blob to blob.
struct Blobs {
  ViewImages view;
  std::vector<Eigen::Vector2d> centres_px;
};

Blobs DrawBlobs(cv::Size size, double sigma_px, double spacing_px, int num_levels) {
  Blobs blobs;
  cv::Mat1f image(size, 0.1f);
  int i = 0;
  for (double y = spacing_px; y < size.height - spacing_px; y += spacing_px) {
    for (double x = spacing_px; x < size.width - spacing_px; x += spacing_px, ++i) {
      const Eigen::Vector2d centre(x + 0.37 * (i % 7), y + 0.29 * (i % 5));
      blobs.centres_px.push_back(centre);
      const int reach = static_cast<int>(4 * sigma_px);
      for (int v = static_cast<int>(centre.y()) - reach; v <= static_cast<int>(centre.y()) + reach; ++v) {
        for (int u = static_cast<int>(centre.x()) - reach; u <= static_cast<int>(centre.x()) + reach; ++u) {
          const double d2 = (Eigen::Vector2d(u, v) - centre).squaredNorm();
          image(v, u) += static_cast<float>(0.8 * std::exp(-d2 / (2 * sigma_px * sigma_px)));
        }
      }
    }
  }
  blobs.view.gray = BuildPyramid(image, num_levels);
  return blobs;
}

/// Mean of (feature - nearest blob) over the features within 1 sigma of one.
Eigen::Vector2d MeanOffset(const Blobs& blobs, const SiftFeatures& features, double sigma_px) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const Eigen::Vector2d& x : features.x_px) {
    for (const Eigen::Vector2d& centre : blobs.centres_px) {
      if ((x - centre).norm() > sigma_px) continue;
      sum += x - centre;
      ++count;
    }
  }
  EXPECT_GT(count, 20);
  return sum / count;
}

TEST(SiftFeatures, PixelZeroIsACentre) {
  for (const double sigma : {2.0, 3.0, 5.0}) {  // found in different octaves of the detector
    const Blobs blobs = DrawBlobs({400, 300}, sigma, 10 * sigma, 1);
    // Without the correction of OpenCV's quarter of a pixel the offset is 0.25.
    EXPECT_LT(MeanOffset(blobs, FindSiftFeatures(blobs.view, 3000), sigma).norm(), 0.03) << "blob of " << sigma;
  }
}

TEST(SiftFeatures, LargePicturesAreSearchedAtALevelButReportedAtFullSize) {
  constexpr double kSigma = 6;
  const Blobs blobs = DrawBlobs({1800, 400}, kSigma, 80, 3);
  EXPECT_LT(MeanOffset(blobs, FindSiftFeatures(blobs.view, 3000), kSigma).norm(), 0.05);
}

TEST(SiftFeatures, StayOnTheObjectAndWithinTheirNumber) {
  Blobs blobs = DrawBlobs({400, 300}, 3, 30, 1);
  blobs.view.mask.create(300, 400);
  blobs.view.mask.setTo(0);
  blobs.view.mask.colRange(200, 400).setTo(255);
  const SiftFeatures features = FindSiftFeatures(blobs.view, 20);
  EXPECT_EQ(features.Count(), 20);
  EXPECT_EQ(features.descriptors.cols(), 20);
  for (const Eigen::Vector2d& x : features.x_px) EXPECT_GE(x.x(), 199.5);
  EXPECT_NEAR(features.descriptors.col(3).norm(), 1, 1e-5);
  EXPECT_LE(features.num_places, 20);
}

TEST(SiftFeatures, NoneInAnEmptyPicture) {
  ViewImages view;
  view.gray = BuildPyramid(cv::Mat1f(100, 100, 0.0f), 1);
  EXPECT_EQ(FindSiftFeatures(view, 100).Count(), 0);
}

}  // namespace
}  // namespace rigcal
