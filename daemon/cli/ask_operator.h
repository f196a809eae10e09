#pragma once

#include <stop_token>
#include <string>

#include "core/base/result.h"

namespace rigcal {

/// Whether somebody sits at a terminal who can be asked.
bool OperatorIsThere();

/// Says what is to be done and waits until the operator presses Enter; what was typed before does not count. Errors:
/// kTimeout, kCancelled; kDevice: the terminal is gone.
Result<void> AskOperator(const std::string& what, double timeout_s, const std::stop_token& stop);

}  // namespace rigcal
