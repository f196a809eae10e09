#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "drivers/genicam/camera_setup.h"
#include "drivers/genicam/genicam_options.h"
#include "drivers/genicam/gobject_pointer.h"

namespace rigcal {

/// How pictures get from the network into the program.
struct ReceivePath {
  std::int64_t buffer_bytes = 0;  ///< of the socket; the kernel gives at most net.core.rmem_max
  bool packet_socket = false;     ///< instead, from the interface itself: needs CAP_NET_RAW
  /// What is wrong with it and what to do, a sentence without a subject; empty: nothing.
  std::string warning;
};

/// The best path from a network that there is for frames of this size.
ReceivePath ChooseReceivePath(std::size_t payload_bytes, const GenicamOptions& options);

/// A frame as it came. Its bytes are valid until the next one is asked for.
struct ReceivedFrame {
  std::string flaw;            ///< why it is no whole picture; empty: it is
  std::uint64_t taken_ns = 0;  ///< by the camera's clock; 0: it did not come
  int width_px = 0, height_px = 0;
  std::span<const std::uint8_t> bytes;
};

/// The way in of one opened camera's pictures, and Aravis' thread that puts packets together.
class FrameStream {
 public:
  /// Errors: kDevice, kTimeout, kCancelled, without a subject.
  static Result<std::unique_ptr<FrameStream>> Start(ArvCamera* camera, std::size_t payload_bytes,
                                                    const ReceivePath& path, const GenicamOptions& options,
                                                    Clock& clock, const std::stop_token& stop);
  ~FrameStream();
  FrameStream(const FrameStream&) = delete;
  FrameStream& operator=(const FrameStream&) = delete;

  /// The next frame, complete or given up; nothing when none came within wait_s of real time.
  std::optional<ReceivedFrame> Next(double wait_s);

  /// What has come since it began: packets, of a USB camera bytes.
  [[nodiscard]] std::uint64_t NumReceived() const;

 private:
  FrameStream(GObjectPointer<ArvStream> stream, bool network) : stream_(std::move(stream)), network_(network) {}
  void GiveBack();

  GObjectPointer<ArvStream> stream_;
  bool network_;
  ArvBuffer* lent_ = nullptr;  ///< the last frame's
};

}  // namespace rigcal
