#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "core/base/execution.h"
#include "core/seed/chart_state.h"

namespace rigcal {

/// Where the unknowns stand in a vector of all that is estimated; -1: not estimated.
struct ChartColumns {
  std::vector<std::array<int, kNumIntrinsics>> intrinsics;  ///< per camera
  std::vector<int> mount;                                   ///< per camera, first of 6
  std::vector<std::array<int, kStopErrorSize>> stop_error;  ///< per stop
  std::vector<int> pose;                                    ///< per view without a stop, first of 6
  std::array<int, 9> axes = {};
  int shape = -1, place = -1, anchor = -1;  ///< first of 3, 4, 6
  int count = 0;
};

/// Robust losses, in sigmas; 0: none.
struct ChartLosses {
  double corner_huber = 0;
  double corner_cauchy = 0;      ///< takes the place of corner_huber
  double stop_error_cauchy = 0;  ///< so that a slipped stop does not bend the others
};

/// The problem linearised at a state. Rows: two for each corner (view by view), then the priors; all whitened.
struct ChartLinearisation {
  Eigen::VectorXd residuals;
  std::vector<int> row_of_view;    ///< per view: its first row
  std::vector<double> row_weight;  ///< of the robust loss
  Eigen::MatrixXd information;     ///< J^T W J
  Eigen::MatrixXd covariance;      ///< its inverse
  Eigen::VectorXd gradient;        ///< J^T W r
  /// Per camera: sum over its rows of (1 - leverage): the residuals' degrees of freedom.
  std::vector<double> degrees_of_freedom;
};

/// The adjustment of everything to the chart's corners and the priors.
class ChartProblem {
 public:
  ChartProblem(const ChartTerms& terms, const ChartLosses& losses, const ChartState& state);
  ~ChartProblem();
  ChartProblem(ChartProblem&&) noexcept;

  /// Moves `state` to the minimum; returns the number of iterations. Errors: kCancelled; kBadInput without a solution.
  Result<int> Solve(const Execution& execution, ChartState& state);
  [[nodiscard]] ChartLinearisation Linearise();
  [[nodiscard]] const ChartColumns& Columns() const;

 private:
  struct Blocks;
  std::unique_ptr<Blocks> blocks_;
};

}  // namespace rigcal
