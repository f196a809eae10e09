#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/execution.h"
#include "core/scene/image_set.h"

namespace rigcal {

/// SIFT features of one picture, strongest first.
struct SiftFeatures {
  std::vector<Eigen::Vector2d> x_px;  ///< undistorted picture, full size, (0,0) = centre of the first pixel
  std::vector<double> scale_px;       ///< the detector's sigma, full-size pixels
  /// 128 x count, RootSIFT (square roots of the L1-normalised histograms), unit length: the dot product of two is their
  /// similarity in [0, 1].
  Eigen::MatrixXf descriptors;
  /// Equal for features at the same place (SIFT repeats a place once for each dominant orientation); in [0,
  /// num_places).
  std::vector<int> place;
  int num_places = 0;

  [[nodiscard]] int Count() const { return static_cast<int>(x_px.size()); }
};

/// The strongest features on the object, found at the first pyramid level whose longer side is at most 1600 px.
SiftFeatures FindSiftFeatures(const ViewImages& view, int max_features);

/// For all views; nothing when stopped.
std::optional<std::vector<SiftFeatures>> FindSiftFeatures(const ImageSet& images, int max_features,
                                                          const Execution& execution);

}  // namespace rigcal
