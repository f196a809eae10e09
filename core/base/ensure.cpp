#include "core/base/ensure.h"

#include <fmt/format.h>

namespace rigcal {

void Ensure(bool condition, std::string_view what, std::source_location where) {
  if (!condition) {
    throw BrokenPromise(fmt::format("{}:{}: {}: {}", where.file_name(), where.line(), where.function_name(), what));
  }
}

}  // namespace rigcal
