#include "daemon/cli/command.h"

#include <fmt/format.h>

#include <cstdio>

namespace rigcal {

int FailWith(const char* command, const Error& error) {
  fmt::print(stderr, "rigcal {}: {}\n", command, error.message);
  return error.code == ErrorCode::kCancelled ? kExitInternal : kExitBadInput;
}

}  // namespace rigcal
