#include "sim_fixtures/gige/gige_device.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

namespace rigcal::sim {
namespace {

constexpr int kSlice_ms = 10;               ///< between two looks at the stop token and the controller's heartbeat
constexpr int kSendBuffer_bytes = 1 << 23;  ///< asked for; the kernel gives what it allows
constexpr std::size_t kFramesKept = 4;      ///< for resending
constexpr std::size_t kMostDatagram_bytes = 2048;
constexpr int kFirstTry = 2, kLastTry = 250;  ///< last byte of the addresses that are tried
constexpr std::uint32_t kLimitedBroadcast = 0xffffffff, kLoopbackBroadcast = 0x7fffffff;
constexpr int kPaceCheck_packets = 16;

sockaddr_in SocketAddress(const GigeEndpoint& endpoint) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(endpoint.port);
  address.sin_addr.s_addr = htonl(endpoint.ip);
  return address;
}

GigeEndpoint Endpoint(const sockaddr_in& address) {
  return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
}

/// A UDP socket bound to an endpoint; closed when that fails, errno says why.
Descriptor BoundSocket(const GigeEndpoint& at, bool shared) {
  Descriptor socket_of(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int on = 1;
  if (shared) setsockopt(socket_of.Number(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const sockaddr_in address = SocketAddress(at);
  if (bind(socket_of.Number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) socket_of.Close();
  return socket_of;
}

}  // namespace

std::optional<std::uint32_t> ParseIp(const std::string& text) {
  in_addr address{};
  if (inet_pton(AF_INET, text.c_str(), &address) != 1) return std::nullopt;
  return ntohl(address.s_addr);
}

std::string IpText(std::uint32_t ip) {
  return fmt::format("{}.{}.{}.{}", ip >> 24, ip >> 16 & 0xff, ip >> 8 & 0xff, ip & 0xff);
}

Result<std::unique_ptr<GigeDevice>> GigeDevice::Start(const GigeDeviceOptions& options, GigePictureSource source) {
  std::unique_ptr<GigeDevice> device(new GigeDevice(options, std::move(source)));
  Result<void> bound;
  if (!options.address.empty()) {
    bound = device->Bind(options.address);
  } else {
    const int pid = getpid();  // programs that run at once begin at different addresses
    for (int last = kFirstTry; last <= kLastTry; ++last) {
      bound = device->Bind(fmt::format("127.{}.{}.{}", 1 + pid / 250 % 250, pid % 250, last));
      if (bound) break;
    }
  }
  if (!bound) return Fail(bound.error());
  device->control_thread_ = std::jthread([raw = device.get()](const std::stop_token& stop) { raw->Control(stop); });
  device->stream_thread_ = std::jthread([raw = device.get()](const std::stop_token& stop) { raw->Stream(stop); });
  return device;
}

GigeDevice::GigeDevice(const GigeDeviceOptions& options, GigePictureSource source)
    : options_(options), source_(std::move(source)), random_(options.random_seed) {}

GigeDevice::~GigeDevice() {
  control_thread_.request_stop();
  stream_thread_.request_stop();
  if (control_thread_.joinable()) control_thread_.join();
  if (stream_thread_.joinable()) stream_thread_.join();
}

Result<void> GigeDevice::Bind(const std::string& address) {
  const std::optional<std::uint32_t> ip = ParseIp(address);
  if (!ip) return Fail(ErrorCode::kIo, "GigE Vision device: '{}' is no IPv4 address", address);
  Descriptor control = BoundSocket({*ip, kGvcpPort}, false);
  if (!control.Open()) {
    return Fail(ErrorCode::kIo, "GigE Vision device: {}:{} cannot be bound: {}", address, kGvcpPort,
                std::generic_category().message(errno));
  }
  Descriptor stream = BoundSocket({*ip, 0}, false);
  sockaddr_in stream_at{};
  socklen_t size = sizeof stream_at;
  if (!stream.Open() || getsockname(stream.Number(), reinterpret_cast<sockaddr*>(&stream_at), &size) != 0) {
    return Fail(ErrorCode::kIo, "GigE Vision device: {} has no port for the stream: {}", address,
                std::generic_category().message(errno));
  }
  setsockopt(stream.Number(), SOL_SOCKET, SO_SNDBUF, &kSendBuffer_bytes, sizeof kSendBuffer_bytes);
  const std::lock_guard lock(mutex_);
  broadcast_sockets_.clear();
  for (const std::uint32_t everybody : {kLimitedBroadcast, kLoopbackBroadcast}) {
    Descriptor socket_of = BoundSocket({everybody, kGvcpPort}, true);
    if (socket_of.Open()) broadcast_sockets_.push_back(std::move(socket_of));
  }
  address_ = address;
  control_socket_ = std::move(control);
  stream_socket_ = std::move(stream);
  camera_.emplace(options_.camera, Endpoint(stream_at), options_.can_resend);
  return {};
}

GigeFaults GigeDevice::Faults() {
  const std::lock_guard lock(mutex_);
  return faults_;
}

void GigeDevice::Set(const GigeFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
  changed_.notify_all();
}

GigeCounts GigeDevice::Counts() {
  const std::lock_guard lock(mutex_);
  return counts_;
}

int GigeDevice::Packet_bytes() {
  const std::lock_guard lock(mutex_);
  return camera_ ? camera_->Packet_bytes() : 0;
}

void GigeDevice::Kill() {
  std::unique_lock lock(mutex_);
  camera_.reset();
  shots_.clear();
  history_.clear();
  control_socket_.Close();
  stream_socket_.Close();
  broadcast_sockets_.clear();
  // The port is free once nobody waits for the closed socket any more.
  const std::uint64_t seen = num_rounds_;
  changed_.wait(lock, [&] { return num_rounds_ > seen; });
}

Result<void> GigeDevice::Revive() {
  return Bind(std::string(address_));
}

void GigeDevice::SetController(const std::optional<GigeEndpoint>& controller, bool exclusive) {
  const std::lock_guard lock(mutex_);
  if (camera_) camera_->SetController(controller, exclusive, clock_.NowS());
}

void GigeDevice::ForgetStreamTarget() {
  const std::lock_guard lock(mutex_);
  if (camera_) camera_->ForgetStreamTarget();
}

void GigeDevice::Pulse() {
  const std::lock_guard lock(mutex_);
  GigeReaction reaction;
  if (camera_) reaction.shot = camera_->Pulse(clock_.NowS());
  Follow(reaction, {});
}

void GigeDevice::Control(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::vector<pollfd> waited;
    {
      const std::lock_guard lock(mutex_);
      ++num_rounds_;
      changed_.notify_all();
      if (camera_) camera_->Elapse(clock_.NowS());
      waited.push_back({.fd = control_socket_.Number(), .events = POLLIN, .revents = 0});  // passed over when closed
      for (const Descriptor& each : broadcast_sockets_) waited.push_back({each.Number(), POLLIN, 0});
    }
    if (poll(waited.data(), waited.size(), kSlice_ms) <= 0) continue;
    const std::lock_guard lock(mutex_);
    ReceiveFrom(control_socket_);
    for (const Descriptor& each : broadcast_sockets_) ReceiveFrom(each);
  }
}

void GigeDevice::ReceiveFrom(const Descriptor& socket) {
  while (socket.Open() && camera_) {
    std::array<std::uint8_t, kMostDatagram_bytes> bytes{};
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t count =
        recvfrom(socket.Number(), bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (count < 0) return;
    if (faults_.deaf) continue;
    const auto datagram = std::span(bytes).first(static_cast<std::size_t>(count));
    Follow(camera_->Receive(datagram, Endpoint(from), clock_.NowS()), Endpoint(from));
  }
}

void GigeDevice::Follow(const GigeReaction& reaction, const GigeEndpoint& from) {
  if (!reaction.answer.empty()) {
    const sockaddr_in to = SocketAddress(from);
    sendto(control_socket_.Number(), reaction.answer.data(), reaction.answer.size(), 0,
           reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  if (reaction.test_packet) SendTestPacket();
  if (reaction.resend) SendAgain(*reaction.resend);
  if (reaction.shot) {
    shots_.push_back(*reaction.shot);
    changed_.notify_all();
  }
}

void GigeDevice::SendPacket(const Bytes& packet) {
  if (!camera_ || !stream_socket_.Open() || faults_.deaf) return;
  const bool too_large = static_cast<int>(packet.size()) + kIpUdp_bytes > faults_.path_packet_bytes.value_or(1 << 16);
  if (too_large || std::uniform_real_distribution<>()(random_) < faults_.loss) {
    ++counts_.lost;
    return;
  }
  const sockaddr_in to = SocketAddress(camera_->StreamTarget());
  sendto(stream_socket_.Number(), packet.data(), packet.size(), MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&to),
         sizeof to);
}

void GigeDevice::SendTestPacket() {
  SendPacket(Bytes(static_cast<std::size_t>(camera_->Packet_bytes() - kIpUdp_bytes)));
}

void GigeDevice::SendAgain(const GigeResend& wanted) {
  if (!options_.can_resend) return;
  // The newest with that number: each start of the acquisition counts anew.
  const auto found = std::ranges::find(history_.rbegin(), history_.rend(), wanted.frame,
                                       [](const auto& frame) { return frame->Number(); });
  if (found == history_.rend()) return;
  const GigeFrame& frame = **found;
  const std::uint32_t end = std::min(wanted.last + 1, frame.NumPackets() - (faults_.truncated ? 2 : 0));
  Bytes packet;
  for (std::uint32_t p = wanted.first; p < end; ++p) {
    frame.Write(p, true, packet);
    SendPacket(packet);
    ++counts_.resent;
  }
}

void GigeDevice::Stream(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::optional<GigeShot> shot;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [&] { return !shots_.empty(); })) return;
      shot = shots_.front();
      shots_.pop_front();
    }
    const cv::Mat pixels = source_(*shot);
    int packet_bytes = 0;
    {
      std::unique_lock lock(mutex_);
      ++counts_.shots;
      if (!changed_.wait(lock, stop, [&] { return !faults_.held; })) return;
      if (!camera_ || faults_.silent) continue;
      packet_bytes = camera_->Packet_bytes();
    }
    SendFrame(std::make_shared<const GigeFrame>(*shot, pixels, packet_bytes), stop);
  }
}

void GigeDevice::SendFrame(const std::shared_ptr<const GigeFrame>& frame, const std::stop_token& stop) {
  {
    const std::lock_guard lock(mutex_);
    history_.push_back(frame);
    if (history_.size() > kFramesKept) history_.pop_front();
    ++counts_.frames;
  }
  const double begin_s = clock_.NowS();
  double sent_bits = 0;
  Bytes packet;
  for (std::uint32_t p = 0; p < frame->NumPackets() && !stop.stop_requested(); ++p) {
    frame->Write(p, false, packet);
    {
      const std::lock_guard lock(mutex_);
      if (faults_.truncated && p + 2 >= frame->NumPackets()) return;
      SendPacket(packet);
    }
    sent_bits += 8.0 * static_cast<double>(packet.size() + kIpUdp_bytes);
    if (options_.bits_per_second <= 0 || p % kPaceCheck_packets != 0) continue;
    const double ahead_s = begin_s + sent_bits / options_.bits_per_second - clock_.NowS();
    if (ahead_s > 0) clock_.Wait(ahead_s, stop);
  }
}

}  // namespace rigcal::sim
