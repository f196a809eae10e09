#pragma once

#include <source_location>
#include <stdexcept>
#include <string_view>

namespace rigcal {

/// A broken promise inside the program. Caught only where a job ends (the worker, main).
class BrokenPromise : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws BrokenPromise with `what` and the place when `condition` is false. For bugs only, never for bad input.
void Ensure(bool condition, std::string_view what, std::source_location where = std::source_location::current());

}  // namespace rigcal
