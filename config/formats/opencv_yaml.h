#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "core/geometry/camera.h"

namespace rigcal {

/// A matrix as OpenCV's FileStorage takes it.
template <int kRows, int kColumns>
cv::Mat1d ToMat(const Eigen::Matrix<double, kRows, kColumns>& matrix) {
  cv::Mat1d mat(kRows, kColumns);
  for (int row = 0; row < mat.rows; ++row)
    for (int column = 0; column < mat.cols; ++column) mat(row, column) = matrix(row, column);
  return mat;
}

/// k1 k2 p1 p2 k3, OpenCV's order.
cv::Mat1d DistortionCoefficients(const Camera& camera);

/// A FileStorage that writes YAML into memory, begun with a comment.
cv::FileStorage YamlInMemory(const std::string& comment);

}  // namespace rigcal
