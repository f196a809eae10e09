#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace rigcal {

/// Every block's derivative against central differences, along the manifold where the block has one.
inline void ExpectDifferencesAgree(const ceres::CostFunction& residual,
                                   const std::vector<const ceres::Manifold*>& manifolds,
                                   const std::vector<std::vector<double>>& blocks) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto evaluate = [&residual](const std::vector<std::vector<double>>& at, std::vector<RowMajor>* jacobians) {
    Eigen::VectorXd value(residual.num_residuals());
    std::vector<const double*> pointers;
    std::vector<double*> outputs;
    for (std::size_t i = 0; i < at.size(); ++i) {
      pointers.push_back(at[i].data());
      if (jacobians != nullptr) jacobians->emplace_back(value.size(), at[i].size());
    }
    for (std::size_t i = 0; jacobians != nullptr && i < at.size(); ++i) outputs.push_back((*jacobians)[i].data());
    EXPECT_TRUE(residual.Evaluate(pointers.data(), value.data(), jacobians != nullptr ? outputs.data() : nullptr));
    return value;
  };
  std::vector<RowMajor> jacobians;
  evaluate(blocks, &jacobians);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const ceres::EuclideanManifold<Eigen::Dynamic> plain(static_cast<int>(blocks[i].size()));
    const ceres::Manifold& manifold = manifolds[i] != nullptr ? *manifolds[i] : plain;
    RowMajor plus_jacobian(manifold.AmbientSize(), manifold.TangentSize());
    manifold.PlusJacobian(blocks[i].data(), plus_jacobian.data());
    const Eigen::MatrixXd analytic = jacobians[i] * plus_jacobian;
    Eigen::MatrixXd difference(analytic.rows(), analytic.cols());
    for (int k = 0; k < manifold.TangentSize(); ++k) {
      const double step = 1e-7 * std::max(1.0, manifolds[i] == nullptr ? std::abs(blocks[i][k]) : 1.0);
      Eigen::VectorXd delta = Eigen::VectorXd::Zero(manifold.TangentSize());
      auto plus = blocks, minus = blocks;
      delta[k] = step;
      manifold.Plus(blocks[i].data(), delta.data(), plus[i].data());
      delta[k] = -step;
      manifold.Plus(blocks[i].data(), delta.data(), minus[i].data());
      difference.col(k) = (evaluate(plus, nullptr) - evaluate(minus, nullptr)) / (2 * step);
    }
    EXPECT_LT((analytic - difference).norm(), 1e-5 * difference.norm()) << "block " << i;
  }
}

}  // namespace rigcal
