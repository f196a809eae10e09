#include "sim_fixtures/gige/gvcp.h"

namespace rigcal::sim {
namespace {

constexpr std::size_t kHeader_bytes = 8;
constexpr std::uint8_t kKey = 0x42, kAnswerWanted = 0x01;

}  // namespace

std::optional<GvcpRequest> ParseGvcp(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kHeader_bytes || datagram[0] != kKey) return std::nullopt;
  const std::size_t length = GetBigEndian(datagram.subspan(4, 2));
  if (datagram.size() < kHeader_bytes + length) return std::nullopt;
  return GvcpRequest{.command = static_cast<GvcpCommand>(GetBigEndian(datagram.subspan(2, 2))),
                     .id = static_cast<std::uint16_t>(GetBigEndian(datagram.subspan(6, 2))),
                     .wants_answer = (datagram[1] & kAnswerWanted) != 0,
                     .payload = datagram.subspan(kHeader_bytes, length)};
}

Bytes GvcpAnswer(const GvcpRequest& request, GvcpStatus status, std::span<const std::uint8_t> payload) {
  Bytes answer;
  PutBigEndian(answer, static_cast<std::uint16_t>(status), 2);
  PutBigEndian(answer, static_cast<std::uint16_t>(request.command) + 1u, 2);
  PutBigEndian(answer, payload.size(), 2);
  PutBigEndian(answer, request.id, 2);
  answer.insert(answer.end(), payload.begin(), payload.end());
  return answer;
}

}  // namespace rigcal::sim
