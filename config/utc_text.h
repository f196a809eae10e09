#pragma once

#include <chrono>
#include <string>

namespace rigcal {

/// "2026-01-31T23:59:59Z": ISO 8601, UTC, whole seconds.
std::string UtcText(std::chrono::system_clock::time_point time);

}  // namespace rigcal
