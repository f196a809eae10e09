#include "core/base/execution.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>

#include "core/base/ensure.h"

namespace rigcal {

bool ParallelFor(const Execution& execution, int count, const std::function<void(int)>& body, int grain) {
  Ensure(grain >= 1, "a thread takes an index at a time");
  if (execution.num_threads <= 1) {
    for (int i = 0; i < count; ++i) {
      if (execution.Stopped()) return false;
      body(i);
    }
    return !execution.Stopped();
  }
  // More threads than cores are allowed: without this, oneTBB warns on stderr and uses fewer.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(execution.num_threads));
  tbb::task_arena arena(execution.num_threads);
  std::atomic<int> num_done = 0;
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<int>(0, count, static_cast<std::size_t>(grain)),
        [&](const tbb::blocked_range<int>& range) {
          for (int i = range.begin(); i < range.end(); ++i) {
            if (execution.Stopped()) return;
            body(i);
            ++num_done;
          }
        },
        tbb::simple_partitioner());
  });
  const bool stopped = execution.Stopped();
  Ensure(stopped || num_done == count, "a parallel loop ran whole");
  return !stopped;
}

}  // namespace rigcal
