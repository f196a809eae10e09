#pragma once

#include <CLI/CLI.hpp>

namespace rigcal {

/// Refuses what is not a number from `least` to `most`. CLI::Range lets nan pass.
CLI::Validator NumberWithin(double least, double most);

/// --threads N: how many threads the stages use, 0 for one on each processor. Results do not depend on it.
void AddThreadsOption(CLI::App& command, int& num_threads);

}  // namespace rigcal
