#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace rigcal {

/// A number with 17 significant digits, which bring back the same double, whatever the locale.
std::string NumberText(double number);

/// "1.5 2 3"; another separator on request.
std::string NumbersText(const std::vector<double>& numbers, std::string_view separator = " ");

/// The entries of a matrix row by row.
template <typename Derived>
std::vector<double> RowByRow(const Eigen::MatrixBase<Derived>& matrix) {
  std::vector<double> entries;
  for (int row = 0; row < matrix.rows(); ++row)
    for (int column = 0; column < matrix.cols(); ++column) entries.push_back(matrix(row, column));
  return entries;
}

}  // namespace rigcal
