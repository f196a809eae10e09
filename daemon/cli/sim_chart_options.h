#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "sim_fixtures/studio.h"

namespace rigcal {

/// --chart and what says more about the board.
struct SimChartRequest {
  std::filesystem::path file;  ///< board.toml; empty: there is an object on the table
  std::vector<double> bow_mm;  ///< along x, and along y
  sim::ChartOptions options;   ///< all but print and bow
};

void AddSimChartOptions(CLI::App& command, SimChartRequest& request);

/// Nothing without --chart. Errors: those of ReadFile and ParseBoard; kBadInput: more than two bows.
Result<std::optional<sim::ChartOptions>> ChartOf(const SimChartRequest& request);

/// One `--OPTION INDEX:NUMBER`.
struct IndexedNumber {
  int index = 0;
  double number = 0;
};

/// How an option's faults are written: what may stand before the index ("cam1:0.5"), and the words for the number.
struct FaultOption {
  const char *name, *prefix, *number;
};

/// Errors: kBadInput.
Result<std::vector<IndexedNumber>> FaultsOf(const FaultOption& option, const std::vector<std::string>& given);

}  // namespace rigcal
