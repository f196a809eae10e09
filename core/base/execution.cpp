#include "core/base/execution.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

namespace rigcal {

bool ParallelFor(const Execution& execution, int count, const std::function<void(int)>& body) {
  if (execution.num_threads <= 1) {
    for (int i = 0; i < count; ++i) {
      if (execution.Stopped()) return false;
      body(i);
    }
    return !execution.Stopped();
  }
  tbb::task_arena arena(std::max(1, execution.num_threads));
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<int>(0, count, 1),
        [&](const tbb::blocked_range<int>& range) {
          for (int i = range.begin(); i < range.end(); ++i) {
            if (execution.Stopped()) return;
            body(i);
          }
        },
        tbb::simple_partitioner());
  });
  return !execution.Stopped();
}

}  // namespace rigcal
