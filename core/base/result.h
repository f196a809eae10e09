#pragma once

#include <fmt/format.h>

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace rigcal {

/// What kind of failure of the outside world an Error reports. Bugs throw (ensure.h); absence is std::optional.
enum class ErrorCode {
  kBadInput,     ///< a file, key or option has a value that cannot be used
  kNotFound,     ///< a file, folder, view or device is not there
  kIo,           ///< reading or writing failed
  kDiskFull,     ///< no space left where something was to be written
  kUnsupported,  ///< valid, but outside what this program does
  kCancelled,    ///< the stop token was set
  kTimeout,      ///< a bounded wait ended without its event
  kDevice,       ///< a camera or positioner failed
  kConflict,     ///< others were there first: what the asker relied on is no longer so; look again, then ask again
};

/// One sentence: what failed, on what (file, key, image), which value, which limit.
struct Error {
  ErrorCode code;
  std::string message;
};

/// The outcome of anything that depends on the outside world.
template <typename T>
class [[nodiscard]] Result : public tl::expected<T, Error> {
 public:
  using tl::expected<T, Error>::expected;
};

/// Makes the Error of a Result: `return Fail(ErrorCode::kIo, "{}: cannot be read", path);`
template <typename... Args>
[[nodiscard]] tl::unexpected<Error> Fail(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(Error{code, fmt::format(format, std::forward<Args>(args)...)});
}

/// Hands on the Error of another Result.
[[nodiscard]] inline tl::unexpected<Error> Fail(const Error& error) {
  return tl::unexpected<Error>(error);
}

}  // namespace rigcal
