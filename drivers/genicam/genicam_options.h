#pragma once

#include <cstdint>
#include <optional>

#include "drivers/genicam/gvcp_client.h"

namespace rigcal {

/// How the driver waits and receives. The defaults are for cameras of a studio; tests shorten the waits.
struct GenicamOptions {
  GigeReach reach = GigeReach::kAllInterfaces;  ///< of a search by serial number
  /// A camera that has not answered within it is away; five questions, at a network's delay of some milliseconds.
  double answer_s = 1;
  /// How long a camera may be held by a program of this machine that is gone: GigE Vision's usual heartbeat of 3 s, and
  /// some.
  double abandoned_s = 4;
  /// A pause after which what is left of a frame is asked for again. A sender on a busy machine may well rest for 20
  /// ms, Aravis' own value; then much comes twice. Packets that are overtaken by others are asked for at once.
  double packet_timeout_s = 0.1;
  /// A frame of which nothing has come for so long is closed: several rounds of asking again.
  double frame_retention_s = 0.5;
  /// Where no receive buffer can hold a picture, pictures are taken from the network interface itself, if the program
  /// may (CAP_NET_RAW).
  bool packet_socket = true;
  /// Largest receive buffer of a socket; absent: what net.core.rmem_max says.
  std::optional<std::int64_t> most_receive_buffer_bytes;
};

}  // namespace rigcal
