#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string>
#include <thread>

#include "core/base/clock.h"
#include "core/base/descriptor.h"
#include "core/base/result.h"
#include "sim_fixtures/gige/gige_camera.h"
#include "sim_fixtures/gige/gige_frame.h"

namespace rigcal::sim {

/// What the camera sees: pixels for a shot, CV_8U or CV_16U (values in the low bits) as its format asks, of its size.
/// Called by the device's own thread, one shot after the other.
using GigePictureSource = std::function<cv::Mat(const GigeShot& shot)>;

struct GigeDeviceOptions {
  GigeCameraSpec camera;
  std::string address;            ///< an IPv4 address of this machine; empty: one of 127/8 that is free
  bool can_resend = true;         ///< announces that it sends packets again, and does
  double bits_per_second = 0;     ///< of the stream; 0: as quickly as the machine can
  std::uint64_t random_seed = 1;  ///< of the packets that are lost
};

/// What can be wrong with it, switched while it runs.
struct GigeFaults {
  double loss = 0;                       ///< share of the stream's packets that are lost, resent ones among them
  bool silent = false;                   ///< takes triggers, sends no pictures
  bool truncated = false;                ///< ends each picture before its last bytes and never sends them
  bool held = false;                     ///< pictures wait in the camera until this is off
  bool deaf = false;                     ///< hears nothing, sends nothing; what it was doing it keeps on
  std::optional<int> path_packet_bytes;  ///< larger packets of the stream get lost
};

struct GigeCounts {
  std::uint64_t shots = 0;   ///< exposures
  std::uint64_t frames = 0;  ///< sent, whole or not
  std::uint64_t lost = 0;    ///< packets that a fault took
  std::uint64_t resent = 0;  ///< packets sent again on request
};

/// A simulated GigE Vision camera on UDP port 3956 of an address of this machine, served by threads of its own. Safe to
/// use from several threads. It answers discoveries that are sent to its address, and where the port can be shared
/// those sent to everybody.
class GigeDevice {
 public:
  /// Errors: kIo: the address cannot be bound, or none of 127/8 is free.
  static Result<std::unique_ptr<GigeDevice>> Start(const GigeDeviceOptions& options, GigePictureSource source);
  ~GigeDevice();
  GigeDevice(const GigeDevice&) = delete;
  GigeDevice& operator=(const GigeDevice&) = delete;

  [[nodiscard]] const std::string& Address() const { return address_; }
  [[nodiscard]] const std::string& Serial() const { return options_.camera.serial; }

  [[nodiscard]] GigeFaults Faults();
  void Set(const GigeFaults& faults);
  [[nodiscard]] GigeCounts Counts();
  /// The stream's packet size as it is set now, all headers counted.
  [[nodiscard]] int Packet_bytes();

  /// Without power: nobody answers at its address.
  void Kill();
  /// Power again: it has forgotten everything. Errors: kIo.
  Result<void> Revive();

  /// Somebody else takes the control away, or nobody has it any more.
  void SetController(const std::optional<GigeEndpoint>& controller, bool exclusive = false);
  /// Forgets where its pictures go to, until it is told anew.
  void ForgetStreamTarget();
  /// A pulse on its trigger line.
  void Pulse();

 private:
  GigeDevice(const GigeDeviceOptions& options, GigePictureSource source);
  Result<void> Bind(const std::string& address);
  void Control(const std::stop_token& stop);
  void ReceiveFrom(const Descriptor& socket);
  void Follow(const GigeReaction& reaction, const GigeEndpoint& from);
  void SendAgain(const GigeResend& wanted);
  void SendTestPacket();
  void Stream(const std::stop_token& stop);
  void SendFrame(const std::shared_ptr<const GigeFrame>& frame, const std::stop_token& stop);
  /// With the lock held.
  void SendPacket(const Bytes& packet);

  GigeDeviceOptions options_;
  GigePictureSource source_;
  SystemClock clock_;
  std::string address_;

  std::mutex mutex_;  ///< guards what follows
  std::condition_variable_any changed_;
  Descriptor control_socket_, stream_socket_;
  std::vector<Descriptor> broadcast_sockets_;
  std::optional<GigeCamera> camera_;
  GigeFaults faults_;
  GigeCounts counts_;
  std::mt19937_64 random_;
  std::uint64_t num_rounds_ = 0;                          ///< of the control thread
  std::deque<GigeShot> shots_;                            ///< not sent yet
  std::deque<std::shared_ptr<const GigeFrame>> history_;  ///< for those who ask again
  std::jthread control_thread_, stream_thread_;           ///< last: they use all of the above
};

/// An IPv4 address as text and as a number whose highest byte is the first. Nothing for what is no address.
std::optional<std::uint32_t> ParseIp(const std::string& text);
std::string IpText(std::uint32_t ip);

}  // namespace rigcal::sim
