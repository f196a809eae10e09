#include "drivers/genicam/gvcp_client.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <system_error>

namespace rigcal {
namespace {

constexpr std::uint16_t kGvcpPort = 3956;
constexpr double kRepeat_s = 0.2;          ///< between two sendings of a question that has no answer yet
constexpr double kEverybodyAnswers_s = 1;  ///< GigE Vision has cameras answer a discovery within that
constexpr int kSlice_ms = 20;              ///< between two looks at the clock and the stop token
constexpr std::size_t kHeader_bytes = 8, kMostDatagram_bytes = 1024, kDiscovery_bytes = 0xf8;
constexpr std::uint16_t kDiscovery = 0x0002, kReadRegister = 0x0080;  ///< commands; an answer's is one more
constexpr std::uint8_t kKey = 0x42, kAnswerWanted = 0x01, kAnswerToAllAllowed = 0x10;
constexpr std::uint16_t kAccessDenied = 0x8006;
constexpr std::uint32_t kControl = 0x0a00, kControllerIp = 0x0a14;  ///< bootstrap registers
constexpr std::size_t kIpAt = 0x24, kVendorAt = 0x48, kModelAt = 0x68, kFirmwareAt = 0x88, kSerialAt = 0xd8;
constexpr std::size_t kName_bytes = 32, kSerial_bytes = 16;

using Bytes = std::vector<std::uint8_t>;

void Put(Bytes& to, std::uint32_t value, int count) {
  for (int shift = 8 * (count - 1); shift >= 0; shift -= 8) to.push_back(static_cast<std::uint8_t>(value >> shift));
}

std::uint32_t Get(const Bytes& from, std::size_t at, int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | from[at + i];
  return value;
}

std::string Text(const Bytes& from, std::size_t at, std::size_t size) {
  const auto begin = from.begin() + static_cast<std::ptrdiff_t>(at);
  return {begin, std::find(begin, begin + static_cast<std::ptrdiff_t>(size), 0)};
}

/// A question and the numbers that tell its answer from others.
struct Question {
  std::uint16_t command = 0, id = 0;
  Bytes datagram;
};

Question Ask(std::uint16_t command, std::uint16_t id, std::uint8_t flags, const Bytes& payload) {
  Question question{.command = command, .id = id, .datagram = {kKey, flags}};
  Put(question.datagram, command, 2);
  Put(question.datagram, static_cast<std::uint32_t>(payload.size()), 2);
  Put(question.datagram, id, 2);
  question.datagram.insert(question.datagram.end(), payload.begin(), payload.end());
  return question;
}

/// A socket and whom it asks.
struct Line {
  Descriptor socket;
  sockaddr_in to{};
};

sockaddr_in At(in_addr address, std::uint16_t port) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  at.sin_addr = address;
  return at;
}

Result<in_addr> ParseAddress(const std::string& address) {
  in_addr parsed{};
  if (inet_pton(AF_INET, address.c_str(), &parsed) == 1) return parsed;
  return Fail(ErrorCode::kBadInput, "'{}' is no IPv4 address", address);
}

std::string AddressText(in_addr address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &address, text.data(), text.size());
  return text.data();
}

Descriptor UdpSocket() {
  return Descriptor(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

Result<Line> LineTo(const std::string& address) {
  const Result<in_addr> parsed = ParseAddress(address);
  if (!parsed) return Fail(parsed.error());
  return Line{UdpSocket(), At(*parsed, kGvcpPort)};
}

/// One line for each interface, to everybody behind it.
std::vector<Line> LinesToEverybody(GigeReach reach) {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(all, freeifaddrs);
  std::vector<Line> lines;
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    if (each->ifa_addr == nullptr || each->ifa_addr->sa_family != AF_INET || (each->ifa_flags & IFF_UP) == 0) continue;
    const bool loopback = (each->ifa_flags & IFF_LOOPBACK) != 0;
    if (!loopback && (reach == GigeReach::kThisMachine || (each->ifa_flags & IFF_BROADCAST) == 0)) continue;
    sockaddr_in own{};
    std::memcpy(&own, each->ifa_addr, sizeof own);
    own.sin_port = 0;
    // 255.255.255.255 also reaches cameras with an address of another network; the loopback interface has none.
    const in_addr everybody{loopback ? htonl(INADDR_LOOPBACK | 0x00ffffff) : INADDR_BROADCAST};
    Line line{UdpSocket(), At(everybody, kGvcpPort)};
    const int on = 1;
    setsockopt(line.socket.Number(), SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
    // Without it 255.255.255.255 leaves by the default route whatever the socket's address is.
    setsockopt(line.socket.Number(), SOL_SOCKET, SO_BINDTODEVICE, each->ifa_name,
               static_cast<socklen_t>(std::strlen(each->ifa_name)));
    if (bind(line.socket.Number(), reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0) {
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

void Send(const Line& line, const Question& question) {
  sendto(line.socket.Number(), question.datagram.data(), question.datagram.size(), 0,
         reinterpret_cast<const sockaddr*>(&line.to), sizeof line.to);  // what fails is asked again
}

using Hear = std::function<bool(std::uint16_t status, const Bytes& payload)>;

/// Hands what has come along a line to `hear`; whether that was enough.
bool HearFrom(const Line& line, const Question& question, const Hear& hear) {
  while (true) {
    Bytes datagram(kMostDatagram_bytes);
    const ssize_t count = recv(line.socket.Number(), datagram.data(), datagram.size(), 0);
    if (count < static_cast<ssize_t>(kHeader_bytes)) return false;
    datagram.resize(static_cast<std::size_t>(count));
    const bool ours = Get(datagram, 2, 2) == question.command + 1u && Get(datagram, 6, 2) == question.id;
    const auto status = static_cast<std::uint16_t>(Get(datagram, 0, 2));
    datagram.erase(datagram.begin(), datagram.begin() + kHeader_bytes);
    if (ours && hear(status, datagram)) return true;
  }
}

/// Asks along all lines, again and again until `hear` has heard enough of the answers (status and payload) or wait_s
/// are over. Errors: kCancelled.
Result<void> Inquire(const std::vector<Line>& lines, const Question& question, double wait_s, const Hear& hear,
                     Clock& clock, const std::stop_token& stop) {
  const double end_s = clock.NowS() + wait_s;
  double ask_s = clock.NowS();
  std::vector<pollfd> waited;
  for (const Line& line : lines) waited.push_back({.fd = line.socket.Number(), .events = POLLIN, .revents = 0});
  for (bool last = false; !last;) {
    if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "looking for cameras was stopped on request");
    last = clock.NowS() >= end_s;  // what came while this program was held up counts
    if (!last && clock.NowS() >= ask_s) {
      for (const Line& line : lines) Send(line, question);
      ask_s = clock.NowS() + kRepeat_s;
    }
    poll(waited.data(), waited.size(), last ? 0 : kSlice_ms);
    for (const Line& line : lines) {
      if (HearFrom(line, question, hear)) return {};
    }
  }
  return {};
}

std::optional<GigeAnswer> ParseAnswer(std::uint16_t status, const Bytes& payload) {
  if (status != 0 || payload.size() < kDiscovery_bytes) return std::nullopt;
  return GigeAnswer{.address = AddressText({htonl(Get(payload, kIpAt, 4))}),
                    .vendor = Text(payload, kVendorAt, kName_bytes),
                    .model = Text(payload, kModelAt, kName_bytes),
                    .firmware = Text(payload, kFirmwareAt, kName_bytes),
                    .serial = Text(payload, kSerialAt, kSerial_bytes)};
}

constexpr std::uint16_t kDiscoveryId = 0xffff;

}  // namespace

Result<std::vector<GigeAnswer>> FindGigeCameras(GigeReach reach, const std::optional<std::string>& serial, Clock& clock,
                                                const std::stop_token& stop) {
  const std::vector<Line> lines = LinesToEverybody(reach);
  if (lines.empty()) return Fail(ErrorCode::kDevice, "no network interface is up that cameras could be asked through");
  std::vector<GigeAnswer> answers;
  const auto hear = [&](std::uint16_t status, const Bytes& payload) {
    const std::optional<GigeAnswer> answer = ParseAnswer(status, payload);
    const auto known = [&](const GigeAnswer& other) {
      return other.serial == answer->serial && other.address == answer->address;
    };
    if (answer && std::ranges::none_of(answers, known)) answers.push_back(*answer);
    return answer && answer->serial == serial;
  };
  const Question question = Ask(kDiscovery, kDiscoveryId, kAnswerWanted | kAnswerToAllAllowed, {});
  if (Result<void> asked = Inquire(lines, question, kEverybodyAnswers_s, hear, clock, stop); !asked) {
    return Fail(asked.error());
  }
  std::ranges::sort(answers, {}, [](const GigeAnswer& answer) { return std::pair(answer.serial, answer.address); });
  return answers;
}

Result<std::optional<GigeAnswer>> AskGigeCamera(const std::string& address, double wait_s, Clock& clock,
                                                const std::stop_token& stop) {
  Result<Line> line = LineTo(address);
  if (!line) return Fail(line.error());
  std::vector<Line> lines;
  lines.push_back(std::move(*line));
  std::optional<GigeAnswer> answer;
  const auto hear = [&](std::uint16_t status, const Bytes& payload) {
    answer = ParseAnswer(status, payload);
    return answer.has_value();
  };
  const Question question = Ask(kDiscovery, kDiscoveryId, kAnswerWanted, {});
  if (Result<void> asked = Inquire(lines, question, wait_s, hear, clock, stop); !asked) return Fail(asked.error());
  return answer;
}

Result<std::optional<GigeHolder>> HolderOfGigeCamera(const std::string& address, double wait_s, Clock& clock,
                                                     const std::stop_token& stop) {
  Result<Line> line = LineTo(address);
  if (!line) return Fail(line.error());
  std::vector<Line> lines;
  lines.push_back(std::move(*line));
  const auto read = [&](std::uint32_t address_of_register, std::uint16_t id) -> Result<std::optional<std::uint32_t>> {
    Bytes payload;
    Put(payload, address_of_register, 4);
    std::optional<std::uint32_t> value;
    bool denied = false, answered = false;
    const auto hear = [&](std::uint16_t status, const Bytes& told) {
      answered = true;
      denied = status == kAccessDenied;
      if (status == 0 && told.size() >= 4) value = Get(told, 0, 4);
      return true;
    };
    const Question question = Ask(kReadRegister, id, kAnswerWanted, payload);
    if (Result<void> asked = Inquire(lines, question, wait_s, hear, clock, stop); !asked) return Fail(asked.error());
    if (!answered) return Fail(ErrorCode::kTimeout, "nothing answers at {} within {:.1f} s", address, wait_s);
    return denied ? std::nullopt : std::optional(value.value_or(0));
  };
  const Result<std::optional<std::uint32_t>> control = read(kControl, 1);
  if (!control) return Fail(control.error());
  if (*control && **control == 0) return std::nullopt;
  const Result<std::optional<std::uint32_t>> ip = read(kControllerIp, 2);
  if (!ip) return Fail(ip.error());
  GigeHolder holder{.exclusive = !*control};
  if (*ip && **ip != 0) holder.address = AddressText({htonl(**ip)});
  return holder;
}

Result<std::string> OwnAddressTowards(const std::string& address) {
  const Result<Line> line = LineTo(address);
  if (!line) return Fail(line.error());
  sockaddr_in own{};
  socklen_t size = sizeof own;
  // Connecting a datagram socket sends nothing; it asks the routes.
  if (connect(line->socket.Number(), reinterpret_cast<const sockaddr*>(&line->to), sizeof line->to) != 0 ||
      getsockname(line->socket.Number(), reinterpret_cast<sockaddr*>(&own), &size) != 0) {
    return Fail(ErrorCode::kDevice, "no network interface leads to {}: {}", address,
                std::generic_category().message(errno));
  }
  return AddressText(own.sin_addr);
}

}  // namespace rigcal
