#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

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

/// A bad input, refused in words that hold all the parts.
template <typename T>
void ExpectRefused(const Result<T>& result, const std::vector<std::string>& parts) {
  ASSERT_FALSE(result) << ::testing::PrintToString(parts);
  EXPECT_EQ(result.error().code, ErrorCode::kBadInput);
  for (const std::string& part : parts) EXPECT_THAT(result.error().message, ::testing::HasSubstr(part));
}

}  // namespace rigcal
