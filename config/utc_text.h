#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace rigcal {

/// "2026-01-31T23:59:59Z": ISO 8601, UTC, whole seconds.
std::string UtcText(std::chrono::system_clock::time_point time);

/// Back, with or without a part of a second ("2025-01-31T12:00:00.5Z"); nothing for another text.
std::optional<std::chrono::system_clock::time_point> TimeFromUtc(const std::string& text);

}  // namespace rigcal
