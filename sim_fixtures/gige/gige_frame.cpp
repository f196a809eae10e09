#include "sim_fixtures/gige/gige_frame.h"

#include <algorithm>

#include "core/base/ensure.h"

namespace rigcal::sim {
namespace {

constexpr int kHeader_bytes = 8;
constexpr std::uint32_t kLeader = 1, kTrailer = 2, kPayload = 3;  ///< kinds of packets
constexpr std::uint32_t kImage = 1;                               ///< kind of payload
constexpr double kTicksPerSecond = 1e9;                           ///< as the camera's registers say
constexpr std::uint32_t kResent = 0x0100;                         ///< status of a packet

}  // namespace

GigeFrame::GigeFrame(const GigeShot& shot, const cv::Mat& pixels, int packet_bytes)
    : shot_(shot),
      pixels_(pixels.clone()),
      payload_bytes_(pixels_.total() * pixels_.elemSize()),
      per_packet_bytes_(packet_bytes - kIpUdp_bytes - kHeader_bytes) {
  Ensure(pixels.size() == cv::Size(shot.width_px, shot.height_px), "a served picture has the size that was asked for");
  Ensure(pixels.elemSize() == static_cast<std::size_t>(shot.format.BytesPerPixel()), "a served picture has its format");
}

std::uint32_t GigeFrame::NumPackets() const {
  return static_cast<std::uint32_t>((payload_bytes_ + per_packet_bytes_ - 1) / per_packet_bytes_) + 2;
}

void GigeFrame::Write(std::uint32_t packet, bool again, Bytes& to) const {
  const bool last = packet == NumPackets() - 1;
  to.clear();
  PutBigEndian(to, again ? kResent : 0, 2);
  PutBigEndian(to, shot_.number, 2);
  PutBigEndian(to, (packet == 0 ? kLeader : last ? kTrailer : kPayload) << 24 | packet, 4);
  if (packet == 0) {
    PutBigEndian(to, kImage, 4);
    PutBigEndian(to, static_cast<std::uint64_t>(shot_.taken_s * kTicksPerSecond), 8);
    PutBigEndian(to, shot_.format.code, 4);
    for (const int value : {shot_.width_px, shot_.height_px, shot_.left_px, shot_.top_px}) PutBigEndian(to, value, 4);
    PutBigEndian(to, 0, 4);  // no padding
  } else if (last) {
    PutBigEndian(to, kImage, 4);
    PutBigEndian(to, shot_.height_px, 4);
  } else {
    const std::size_t begin = (packet - 1) * per_packet_bytes_;
    const std::uint8_t* bytes = pixels_.ptr();  // little-endian, as the host is
    to.insert(to.end(), bytes + begin, bytes + std::min(begin + per_packet_bytes_, payload_bytes_));
  }
}

}  // namespace rigcal::sim
