#include "core/match/pair_matches.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <set>

#include "core/geometry/camera.h"

namespace rigcal {
namespace {

/// Distance to the most similar over distance to the second (Lowe, IJCV 2004).
constexpr float kMaxRatio = 0.8f;
/// With few candidates on the line there may be no honest second one: no match is less similar than this (RootSIFT
/// distance 0.63).
constexpr float kMinSimilarity = 0.8f;
/// Features closer together than this are one place, and not rivals.
constexpr double kSamePlacePx = 3.0;
constexpr int kAlwaysPaired = 2;
/// A pair of pictures with fewer matches that agree on one epipolar geometry may agree by chance.
constexpr int kMinMatchesPerPair = 16;
/// Distance from the epipolar line in full-size pixels of a picture of kReferenceSidePx: SIFT positions are good to
/// half a pixel.
constexpr double kEpipolarTolerancePx = 1.5;

/// The two most similar features seen so far that are not at one place.
struct BestTwo {
  int best = -1;
  float similarity = 0;
  float second_similarity = 0;

  void Offer(int candidate, float s, const std::vector<Eigen::Vector2d>& x_px) {
    const bool same_place = best >= 0 && (x_px[candidate] - x_px[best]).squaredNorm() < kSamePlacePx * kSamePlacePx;
    if (s > similarity) {
      if (!same_place) second_similarity = similarity;
      best = candidate;
      similarity = s;
    } else if (!same_place && s > second_similarity) {
      second_similarity = s;
    }
  }

  [[nodiscard]] bool IsClear() const {
    // |d1 - d2|^2 = 2 - 2 s for unit vectors
    return best >= 0 && similarity >= kMinSimilarity &&
           1 - similarity < kMaxRatio * kMaxRatio * (1 - second_similarity);
  }
};

/// Homogeneous pixels, 3 x count.
Eigen::Matrix3Xf Homogeneous(const SiftFeatures& features) {
  Eigen::Matrix3Xf x(3, features.Count());
  for (int i = 0; i < features.Count(); ++i) x.col(i) = features.x_px[i].homogeneous().cast<float>();
  return x;
}

void OfferAlongLines(const SiftFeatures& a, const SiftFeatures& b, const EpipolarGate& gate, std::vector<BestTwo>& of_a,
                     std::vector<BestTwo>& of_b) {
  const Eigen::Matrix3Xf x_b = Homogeneous(b);
  Eigen::ArrayXf distance(b.Count());
  for (int i = 0; i < a.Count(); ++i) {
    Eigen::Vector3d line = gate.fundamental_b_from_a * a.x_px[i].homogeneous();
    line /= line.head<2>().norm();
    distance = (line.cast<float>().transpose() * x_b).array().abs();
    for (int j = 0; j < b.Count(); ++j) {
      if (!(distance[j] <= static_cast<float>(gate.max_distance_px))) continue;
      const float s = a.descriptors.col(i).dot(b.descriptors.col(j));
      of_a[i].Offer(j, s, b.x_px);
      of_b[j].Offer(i, s, a.x_px);
    }
  }
}

void OfferAll(const SiftFeatures& a, const SiftFeatures& b, std::vector<BestTwo>& of_a, std::vector<BestTwo>& of_b) {
  constexpr int kBlock = 256;  // columns of a at a time: the products stay in the cache
  for (int begin = 0; begin < a.Count(); begin += kBlock) {
    const int count = std::min(kBlock, a.Count() - begin);
    const Eigen::MatrixXf s = b.descriptors.transpose() * a.descriptors.middleCols(begin, count);
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < b.Count(); ++j) {
        of_a[begin + i].Offer(j, s(j, i), b.x_px);
        of_b[j].Offer(begin + i, s(j, i), a.x_px);
      }
    }
  }
}

}  // namespace

std::vector<std::pair<int, int>> NeighbourPairs(const RigCalibration& calibration, int num_neighbours,
                                                double max_angle_rad) {
  const int n = calibration.NumViews();
  std::vector<Eigen::Vector3d> axis;
  for (const View& view : calibration.views) {
    axis.push_back(view.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ());
  }
  std::set<std::pair<int, int>> pairs;
  for (int v = 0; v < n; ++v) {
    std::vector<std::pair<double, int>> others;
    for (int w = 0; w < n; ++w) {
      if (w != v) others.emplace_back(std::acos(std::clamp(axis[v].dot(axis[w]), -1.0, 1.0)), w);
    }
    std::sort(others.begin(), others.end());
    for (int k = 0; k < std::min<int>(num_neighbours, static_cast<int>(others.size())); ++k) {
      if (k < kAlwaysPaired || others[k].first < max_angle_rad) {
        pairs.insert(std::minmax(v, others[k].second));
      }
    }
  }
  return {pairs.begin(), pairs.end()};
}

Eigen::Matrix3d FundamentalMatrix(const RigCalibration& calibration, int view_a, int view_b) {
  const Rigid3d b_from_a =
      calibration.views[view_b].cam_from_world * calibration.views[view_a].cam_from_world.Inverse();
  const Eigen::Matrix3d essential = Skew(b_from_a.translation) * b_from_a.rotation.toRotationMatrix();
  return calibration.CameraOf(view_b).CalibrationMatrix().inverse().transpose() * essential *
         calibration.CameraOf(view_a).CalibrationMatrix().inverse();
}

std::vector<FeatureMatch> MatchFeatures(const SiftFeatures& a, const SiftFeatures& b,
                                        const std::optional<EpipolarGate>& gate) {
  std::vector<BestTwo> of_a(a.x_px.size()), of_b(b.x_px.size());
  if (gate) {
    OfferAlongLines(a, b, *gate, of_a, of_b);
  } else if (a.Count() > 0 && b.Count() > 0) {
    OfferAll(a, b, of_a, of_b);
  }
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < a.Count(); ++i) {
    const BestTwo& found = of_a[i];
    if (found.IsClear() && of_b[found.best].best == i && of_b[found.best].IsClear()) {
      matches.push_back({i, found.best, found.similarity});
    }
  }
  return matches;
}

void KeepConsistent(const SiftFeatures& a, const SiftFeatures& b, std::vector<FeatureMatch>& matches) {
  std::vector<unsigned char> inlier;
  if (static_cast<int>(matches.size()) >= kMinMatchesPerPair) {
    std::vector<cv::Point2d> in_a, in_b;
    for (const FeatureMatch& m : matches) {
      in_a.emplace_back(a.x_px[m.a].x(), a.x_px[m.a].y());
      in_b.emplace_back(b.x_px[m.b].x(), b.x_px[m.b].y());
    }
    constexpr double kConfidence = 0.999;
    constexpr int kMaxTrials = 2000;
    cv::findFundamentalMat(in_a, in_b, cv::FM_RANSAC, kEpipolarTolerancePx, kConfidence, kMaxTrials, inlier);
  }
  std::vector<FeatureMatch> kept;
  for (std::size_t i = 0; i < inlier.size(); ++i) {
    if (inlier[i] != 0) kept.push_back(matches[i]);
  }
  matches = static_cast<int>(kept.size()) >= kMinMatchesPerPair ? std::move(kept) : std::vector<FeatureMatch>{};
}

}  // namespace rigcal
