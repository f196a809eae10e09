#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

#include "sim_fixtures/gige/big_endian.h"
#include "sim_fixtures/gige/gige_camera.h"

namespace rigcal::sim {

inline constexpr int kIpUdp_bytes = 28;  ///< of headers, counted in a packet size of GigE Vision

/// A picture as the packets of the GigE Vision stream protocol: a leader (0), its bytes, a trailer.
class GigeFrame {
 public:
  /// `pixels` is CV_8U or CV_16U as the shot's format asks, of the shot's size. `packet_bytes` counts all headers.
  GigeFrame(const GigeShot& shot, const cv::Mat& pixels, int packet_bytes);

  [[nodiscard]] std::uint16_t Number() const { return shot_.number; }
  [[nodiscard]] std::uint32_t NumPackets() const;
  /// The UDP payload of a packet below NumPackets(), written into `to`; `again` marks it as resent.
  void Write(std::uint32_t packet, bool again, Bytes& to) const;

 private:
  GigeShot shot_;
  cv::Mat pixels_;
  std::size_t payload_bytes_, per_packet_bytes_;
};

}  // namespace rigcal::sim
