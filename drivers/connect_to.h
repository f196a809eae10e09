#pragma once

#include <stop_token>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "core/base/socket_address.h"
#include "drivers/line_connection.h"

namespace rigcal {

/// Connects by TCP within timeout_s of the clock. The host is in numbers or "localhost": no name server is asked, which
/// might take its time. Errors, all without the device's name: kBadInput (such a host), kDevice (refused, no way
/// there), kTimeout, kCancelled.
Result<LineConnection> ConnectTo(const SocketAddress& address, double timeout_s, Clock& clock,
                                 const std::stop_token& stop);

}  // namespace rigcal
