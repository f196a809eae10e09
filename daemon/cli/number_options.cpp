#include "daemon/cli/number_options.h"

#include <fmt/format.h>

namespace rigcal {

CLI::Validator NumberWithin(double least, double most) {
  const auto check = [least, most](const std::string& text) {
    double value = 0;
    const bool within = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
    return within ? std::string() : fmt::format("{} is not a number from {} to {}", text, least, most);
  };
  return {check, fmt::format("FLOAT in [{} - {}]", least, most)};
}

void AddThreadsOption(CLI::App& command, int& num_threads) {
  constexpr int kMaxThreads = 256;
  command.add_option("--threads", num_threads, "Threads; 0: one for each processor")
      ->check(CLI::Range(0, kMaxThreads))
      ->capture_default_str();
}

}  // namespace rigcal
