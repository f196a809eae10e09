#pragma once

#include <gtest/gtest.h>

#include <string>

#include "core/base/result.h"

namespace rigcal {

inline constexpr const char* kNoError = "no error";

/// What a refusal says.
template <typename T>
std::string Message(const Result<T>& result) {
  return result ? kNoError : result.error().message;
}

/// A text with one part of it spoilt; the part must be there.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace rigcal
