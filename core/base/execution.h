#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace rigcal {

/// How a stage runs, as opposed to what it computes: nothing in here may change a result, except that a set stop token
/// ends the stage with ErrorCode::kCancelled.
struct Execution {
  std::stop_token stop;
  int num_threads = 1;
  /// Called with the share of the stage that is done, in [0, 1]; may be empty. Called from one thread at a time.
  std::function<void(double)> report_progress;

  [[nodiscard]] bool Stopped() const { return stop.stop_requested(); }
  void Report(double share) const {
    if (report_progress) report_progress(share);
  }
};

/// The Error with which a stage answers a set stop token.
[[nodiscard]] inline tl::unexpected<Error> Cancelled(std::string_view stage) {
  return Fail(ErrorCode::kCancelled, "{} was stopped on request", stage);
}

/// Calls body(i) for i in [0, count) on at most execution.num_threads threads (oneTBB); polls the stop token before
/// each call and returns false when it was set. The order of the calls is not fixed: body(i) must write to places of
/// its own index only, so that the result does not depend on the number of threads. A thread takes up to `grain`
/// indices at a time: more than one where a call is short. An exception of body reaches the caller.
bool ParallelFor(const Execution& execution, int count, const std::function<void(int)>& body, int grain = 1);

/// The results of body(i) for i in [0, count), by ParallelFor. Errors: that of the first index that has one; kCancelled
/// naming `stage`.
template <typename T>
Result<std::vector<T>> ParallelResults(const Execution& execution, int count, std::string_view stage,
                                       const std::function<Result<T>(int)>& body) {
  std::vector<std::optional<Result<T>>> results(static_cast<std::size_t>(count));
  if (!ParallelFor(execution, count, [&](int i) { results[i] = body(i); })) return Cancelled(stage);
  std::vector<T> values;
  for (std::optional<Result<T>>& result : results) {
    if (!*result) return Fail((*result).error());
    values.push_back(**std::move(result));
  }
  return values;
}

}  // namespace rigcal
