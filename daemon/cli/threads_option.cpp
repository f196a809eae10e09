#include "daemon/cli/threads_option.h"

#include <algorithm>
#include <thread>

namespace rigcal {

void AddThreadsOption(CLI::App& command, int& num_threads) {
  constexpr int kMaxThreads = 256;
  command.add_option("--threads", num_threads, "Threads; 0: one for each processor")
      ->check(CLI::Range(0, kMaxThreads))
      ->capture_default_str();
}

int NumThreads(int wanted) {
  return wanted > 0 ? wanted : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace rigcal
