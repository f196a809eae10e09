#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sim_fixtures/gige/genicam_xml.h"
#include "sim_fixtures/gige/gige_memory.h"
#include "sim_fixtures/gige/gige_pixel_format.h"
#include "sim_fixtures/gige/gvcp.h"

namespace rigcal::sim {

/// Where a datagram comes from or goes to; the address's first byte is its highest.
struct GigeEndpoint {
  std::uint32_t ip = 0;
  std::uint16_t port = 0;
  bool operator==(const GigeEndpoint&) const = default;
};

struct GigeCameraSpec {
  std::string serial = "SIM1", model = "Studio", firmware = "1.0";
  int width_px = 640, height_px = 480;  ///< of the sensor; multiples of limits.region_step_px
  double temperature_celsius = 41.5, gamma = 1;
  bool has_clock = true;  ///< for its pictures' times; without, it says that it has none
  GigeLimits limits;
};

/// One exposure, as the camera was set when it was triggered.
struct GigeShot {
  std::uint16_t number = 0;  ///< 1 and on, after 65535 again 1, from each start of the acquisition
  int left_px = 0, top_px = 0, width_px = 0, height_px = 0;
  GigePixelFormat format;
  double exposure_us = 0, gain_db = 0;
  double taken_s = 0;  ///< by the clock of whoever runs the camera
};

/// Packets first to last of a frame, asked for once more.
struct GigeResend {
  std::uint16_t frame = 0;
  std::uint32_t first = 0, last = 0;
};

/// What a request asks for beyond its answer.
struct GigeReaction {
  Bytes answer;  ///< empty: none
  std::optional<GigeShot> shot;
  std::optional<GigeResend> resend;
  bool test_packet = false;
};

/// The state of a simulated GigE Vision camera: registers, who controls it, whether it acquires. It knows no sockets
/// and no clock of its own; seconds are the caller's, of any steady clock. One controller at a time: what another one
/// writes is denied, and with exclusive access what he reads too. A controller that says nothing for the heartbeat's
/// time is forgotten.
class GigeCamera {
 public:
  /// `stream_source` is where its pictures come from.
  GigeCamera(const GigeCameraSpec& spec, const GigeEndpoint& stream_source, bool can_resend);

  GigeReaction Receive(std::span<const std::uint8_t> datagram, const GigeEndpoint& from, double now_s);
  /// Forgets a controller whose heartbeat has stopped.
  void Elapse(double now_s);
  /// A pulse on its line: a shot, when it waits for one.
  std::optional<GigeShot> Pulse(double now_s);

  /// Gives the control to somebody else, or to nobody; what it acquires ends.
  void SetController(const std::optional<GigeEndpoint>& controller, bool exclusive, double now_s);

  [[nodiscard]] GigeEndpoint StreamTarget() const;
  void ForgetStreamTarget();
  [[nodiscard]] int Packet_bytes() const;  ///< with IP and UDP headers
  [[nodiscard]] const GigeMemory& Registers() const { return memory_; }

 private:
  [[nodiscard]] bool MayRead(const GigeEndpoint& from) const;
  [[nodiscard]] bool MayWrite(const GigeEndpoint& from, std::uint32_t address) const;
  GvcpStatus ReadRegisters(const GvcpRequest& request, Bytes& answer) const;
  GvcpStatus ReadMemory(const GvcpRequest& request, Bytes& answer) const;
  GvcpStatus WriteRegisters(const GvcpRequest& request, const GigeEndpoint& from, double now_s, Bytes& answer,
                            GigeReaction& reaction);
  GvcpStatus WriteMemory(const GvcpRequest& request, const GigeEndpoint& from, double now_s, Bytes& answer,
                         GigeReaction& reaction);
  /// One register, with what follows from it.
  GvcpStatus Write(std::uint32_t address, std::uint32_t value, const GigeEndpoint& from, double now_s,
                   GigeReaction& reaction);
  void LatchTime(double now_s);
  [[nodiscard]] bool Fits(std::uint32_t address, std::uint32_t value) const;
  std::optional<GigeShot> Shoot(std::uint32_t trigger_source, double now_s);

  GigeCameraSpec spec_;
  GigeMemory memory_;
  std::optional<GigeEndpoint> controller_;
  double controller_spoke_s_ = 0;
  bool acquiring_ = false;
  std::uint16_t last_shot_ = 0;
};

}  // namespace rigcal::sim
