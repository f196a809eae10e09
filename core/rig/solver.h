#pragma once

#include <ceres/ceres.h>

#include "core/base/execution.h"

namespace rigcal {

/// Ends a solution by Ceres when the job is stopped.
class StopCallback : public ceres::IterationCallback {
 public:
  explicit StopCallback(const Execution& execution) : execution_(execution) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return execution_.Stopped() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const Execution& execution_;
};

/// For a problem that owns its cost functions alone: losses and manifolds are shared between blocks.
inline ceres::Problem::Options SharingProblemOptions() {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

}  // namespace rigcal
