#include "drivers/genicam/frame_stream.h"

#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/base/descriptor.h"

namespace rigcal {
namespace {

constexpr int kNumBuffers = 3;        ///< one being filled, one looked at, one for a frame that nobody asked for
constexpr double kPacketRoom = 1.25;  ///< a frame's packets in a receive buffer, with the kernel's share of each
constexpr std::int64_t kLeastBuffer_bytes = 1'000'000;  ///< where so much is to be had
constexpr double kSecond_us = 1e6;
/// Resend is asked for at most for so many times a frame's packets. Aravis asks three times for a lost one, and counts
/// those that were only late.
constexpr double kMostResent = 1;
constexpr const char* kIpv4Protocol = "0800";  ///< as /proc/net/packet has it
constexpr const char* kRunning = "1";          ///< the same: its hook is in place
constexpr double kListens_s = 5;               ///< its 32 MB are mapped within 0.1 s
constexpr double kLook_s = 0.002;
constexpr const char* kMostBufferFile = "/proc/sys/net/core/rmem_max";

bool PacketSocketAllowed() {
  return Descriptor(socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0)).Open();  // protocol 0: receives nothing
}

std::int64_t MostReceiveBuffer() {
  std::int64_t bytes = 0;
  std::ifstream(kMostBufferFile) >> bytes;
  return bytes;
}

/// Inodes of this program's packet sockets that receive IPv4 packets.
std::set<std::uint64_t> ListeningPacketSockets() {
  std::set<std::uint64_t> listening;
  std::ifstream table("/proc/net/packet");
  std::string line;
  std::getline(table, line);  // names of the columns
  while (std::getline(table, line)) {
    std::istringstream columns(line);
    std::string socket_at, references, type, protocol, interface_index, running, memory, user;
    std::uint64_t inode = 0;
    columns >> socket_at >> references >> type >> protocol >> interface_index >> running >> memory >> user >> inode;
    if (protocol == kIpv4Protocol && running == kRunning) listening.insert(inode);
  }
  std::set<std::uint64_t> own;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", none)) {
    const std::string target = std::filesystem::read_symlink(entry.path(), none).string();
    constexpr std::string_view kSocket = "socket:[";
    std::uint64_t inode = 0;
    if (!target.starts_with(kSocket)) continue;
    std::from_chars(target.data() + kSocket.size(), target.data() + target.size(), inode);
    if (listening.contains(inode)) own.insert(inode);
  }
  return own;
}

/// Aravis says that its thread has begun before that has a socket; what a camera sends until then is lost. Waits until
/// one more listens. Errors: kTimeout, kCancelled, without a subject.
Result<void> AwaitMoreThan(const std::set<std::uint64_t>& before, Clock& clock, const std::stop_token& stop) {
  const double end_s = clock.NowS() + kListens_s;
  while (std::ranges::includes(before, ListeningPacketSockets())) {
    if (clock.NowS() > end_s) {
      return Fail(ErrorCode::kTimeout, "no packet socket listens {} s after Aravis was asked for one", kListens_s);
    }
    if (!clock.Wait(kLook_s, stop)) return Fail(ErrorCode::kCancelled, "beginning its stream was stopped on request");
  }
  return {};
}

/// A frame's flaw; empty: none.
std::string FlawOf(ArvBuffer* buffer) {
  switch (arv_buffer_get_status(buffer)) {
    case ARV_BUFFER_STATUS_SUCCESS:
      return arv_buffer_get_payload_type(buffer) == ARV_BUFFER_PAYLOAD_TYPE_IMAGE ? "" : "it is no image";
    case ARV_BUFFER_STATUS_TIMEOUT:
      return "its last packets did not come in time";
    case ARV_BUFFER_STATUS_MISSING_PACKETS:
      return "packets of it were lost";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return "it has packets of an unexpected number";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return "it has another size than announced";
    default:
      return "it was broken off";
  }
}

}  // namespace

ReceivePath ChooseReceivePath(std::size_t payload_bytes, const GenicamOptions& options) {
  const auto frame_bytes = static_cast<std::int64_t>(kPacketRoom * static_cast<double>(payload_bytes));
  const std::int64_t wanted_bytes = std::max(kLeastBuffer_bytes, frame_bytes);
  const std::int64_t most_bytes = options.most_receive_buffer_bytes.value_or(MostReceiveBuffer());
  ReceivePath path{.buffer_bytes = std::min(wanted_bytes, most_bytes)};
  if (frame_bytes <= most_bytes) return path;
  path.packet_socket = options.packet_socket && PacketSocketAllowed();
  if (path.packet_socket) return path;
  path.warning = fmt::format(
      "pictures of {} bytes may come incomplete: a receive buffer is at most {} bytes, and this program may not open a "
      "packet socket (CAP_NET_RAW); allow one of them, the first with: sysctl -w net.core.rmem_max={}",
      payload_bytes, most_bytes, wanted_bytes);
  return path;
}

Result<std::unique_ptr<FrameStream>> FrameStream::Start(ArvCamera* camera, std::size_t payload_bytes,
                                                        const ReceivePath& path, const GenicamOptions& options,
                                                        Clock& clock, const std::stop_token& stop) {
  const bool network = arv_camera_is_gv_device(camera) != FALSE;
  if (network) {
    arv_camera_gv_set_stream_options(
        camera, path.packet_socket ? ARV_GV_STREAM_OPTION_NONE : ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  }
  const std::set<std::uint64_t> before = ListeningPacketSockets();
  GLibError error;
  GObjectPointer<ArvStream> stream(arv_camera_create_stream(camera, nullptr, nullptr, error.Take()));
  if (!stream) return Fail(ErrorCode::kDevice, "no stream of pictures can be made: {}", error.Text());
  if (network) {
    g_object_set(stream.get(), "packet-timeout", static_cast<guint>(options.packet_timeout_s * kSecond_us),
                 "frame-retention", static_cast<guint>(options.frame_retention_s * kSecond_us), "packet-request-ratio",
                 kMostResent, nullptr);
    if (!path.packet_socket) {
      g_object_set(stream.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                   static_cast<gint>(path.buffer_bytes), nullptr);
    }
  }
  for (int i = 0; i < kNumBuffers; ++i) arv_stream_push_buffer(stream.get(), arv_buffer_new_allocate(payload_bytes));
  if (network && path.packet_socket) {
    if (Result<void> listens = AwaitMoreThan(before, clock, stop); !listens) return Fail(listens.error());
  }
  return std::unique_ptr<FrameStream>(new FrameStream(std::move(stream), network));
}

FrameStream::~FrameStream() {
  GiveBack();
}

void FrameStream::GiveBack() {
  if (lent_ == nullptr) return;
  arv_buffer_set_timestamp(lent_, 0);  // the next frame in it may come without its leader
  arv_stream_push_buffer(stream_.get(), std::exchange(lent_, nullptr));
}

std::optional<ReceivedFrame> FrameStream::Next(double wait_s) {
  GiveBack();
  const auto wait_us = static_cast<guint64>(wait_s * kSecond_us);
  lent_ =
      wait_us > 0 ? arv_stream_timeout_pop_buffer(stream_.get(), wait_us) : arv_stream_try_pop_buffer(stream_.get());
  if (lent_ == nullptr) return std::nullopt;
  ReceivedFrame frame{.flaw = FlawOf(lent_), .taken_ns = arv_buffer_get_timestamp(lent_)};
  if (!frame.flaw.empty()) return frame;
  frame.width_px = arv_buffer_get_image_width(lent_);
  frame.height_px = arv_buffer_get_image_height(lent_);
  std::size_t size = 0;
  const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_data(lent_, &size));
  frame.bytes = {data, size};
  return frame;
}

std::uint64_t FrameStream::NumReceived() const {
  return arv_stream_get_info_uint64_by_name(stream_.get(), network_ ? "n_received_packets" : "n_transferred_bytes");
}

}  // namespace rigcal
