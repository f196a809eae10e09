#include "sim_fixtures/u3v/u3v_camera.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "core/base/ensure.h"
#include "sim_fixtures/u3v/u3v_descriptors.h"
#include "sim_fixtures/u3v/u3v_registers.h"
#include "sim_fixtures/u3v/u3v_xml.h"

namespace rigcal::sim {
namespace {

// GenCP: magic, flags or status (2 bytes), command (2), length (2), number (2)
constexpr std::uint32_t kCommandMagic = 0x43563355, kLeaderMagic = 0x4c563355, kTrailerMagic = 0x54563355;
constexpr std::size_t kHead_bytes = 12, kAddress_bytes = 8;
constexpr std::uint16_t kRead = 0x0800, kWrite = 0x0802;
constexpr std::uint16_t kGood = 0, kNotImplemented = 0x8001, kInvalidAddress = 0x8003, kInvalidHeader = 0x800e;
constexpr std::size_t kLeader_bytes = 52, kTrailer_bytes = 32;
constexpr std::uint32_t kMono8 = 0x01080001, kMono16 = 0x01100007;
constexpr std::uint32_t kMostTransfer_bytes = 1024;  ///< of a command or an answer
/// Aravis waits at least so long for each answer, five times over, and for pictures too before it looks whether it is
/// to stop: long enough for a busy machine, short enough for tests that open the camera twenty times.
constexpr std::uint32_t kResponse_ms = 200;
constexpr std::size_t kLeftOut_bytes = 4096;  ///< of a truncated picture

std::uint64_t Now_ns() {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
}

/// An answer of GenCP to the request with this number.
Bytes AnswerTo(std::uint16_t kind, std::uint16_t request, std::uint16_t status, std::span<const std::uint8_t> content) {
  Bytes answer(kHead_bytes + content.size(), 0);
  const std::span bytes(answer);
  SetLittle(bytes, 0, kCommandMagic);
  SetLittle(bytes, 4, status);
  SetLittle(bytes, 6, static_cast<std::uint16_t>(kind + 1));
  SetLittle(bytes, 8, static_cast<std::uint16_t>(content.size()));
  SetLittle(bytes, 10, request);
  std::ranges::copy(content, bytes.begin() + kHead_bytes);
  return answer;
}

}  // namespace

U3vCamera::U3vCamera(const U3vCameraSpec& spec, U3vPictureSource source) : spec_(spec), source_(std::move(source)) {
  PowerOn();
}

U3vFaults U3vCamera::Faults() const {
  const std::lock_guard lock(mutex_);
  return faults_;
}

void U3vCamera::Set(const U3vFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
}

bool U3vCamera::AwaitStalled(double timeout_s) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::duration<double>(timeout_s), [&] { return stalled_; });
}

bool U3vCamera::AwaitShots(std::uint64_t count, double timeout_s) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::duration<double>(timeout_s), [&] { return num_shots_ >= count; });
}

void U3vCamera::PutText(std::size_t address, const std::string& text) {
  Ensure(text.size() < abrm::kText_bytes, "a camera's texts have at most 63 bytes");
  std::ranges::copy(text, memory_.begin() + static_cast<std::ptrdiff_t>(address));
}

void U3vCamera::PowerOn() {
  const std::lock_guard lock(mutex_);
  memory_.assign(kMemory_bytes, 0);
  answers_.clear();
  shots_.clear();
  acquiring_ = stalled_ = false;
  phase_ = Phase::kLeader;
  Put<std::uint32_t>(abrm::kVersion, 0x00010001);
  PutText(abrm::kVendor, spec_.vendor);
  PutText(abrm::kModel, spec_.model);
  PutText(abrm::kSerial, spec_.serial);
  PutText(abrm::kDeviceVersion, "1.0");
  Put<std::uint32_t>(abrm::kResponse_ms, kResponse_ms);
  Put<std::uint64_t>(abrm::kManifest, manifest::kBegin);
  Put<std::uint64_t>(abrm::kTechnology, sbrm::kBegin);
  Put<std::uint32_t>(sbrm::kVersion, 0x00010001);
  Put<std::uint32_t>(sbrm::kMostCommand_bytes, kMostTransfer_bytes);
  Put<std::uint32_t>(sbrm::kMostAnswer_bytes, kMostTransfer_bytes);
  Put<std::uint32_t>(sbrm::kNumStreams, 1);
  Put<std::uint64_t>(sbrm::kStream, sirm::kBegin);
  Put<std::uint32_t>(sbrm::kStream_bytes, 0x30);
  Put<std::uint32_t>(sirm::kLeader_bytes, kLeader_bytes);
  Put<std::uint32_t>(sirm::kTrailer_bytes, kTrailer_bytes);
  const std::string xml = U3vXml();
  Ensure(kXmlBegin + xml.size() <= kMemory_bytes, "the description fits into the camera's memory");
  std::ranges::copy(xml, memory_.begin() + static_cast<std::ptrdiff_t>(kXmlBegin));
  Put<std::uint64_t>(manifest::kCount, 1);
  Put<std::uint64_t>(manifest::kXmlAddress, kXmlBegin);
  Put<std::uint64_t>(manifest::kXml_bytes, xml.size());
  for (const std::size_t address : {feature::kSensorWidth, feature::kWidth}) {
    Put<std::uint32_t>(address, static_cast<std::uint32_t>(spec_.width_px));
  }
  for (const std::size_t address : {feature::kSensorHeight, feature::kHeight}) {
    Put<std::uint32_t>(address, static_cast<std::uint32_t>(spec_.height_px));
  }
  Put<std::uint32_t>(feature::kPixelFormat, kMono8);
  Put<float>(feature::kExposure_us, 10000);
  Put<float>(feature::kGamma, 1);
  Put<float>(feature::kTemperature, static_cast<float>(spec_.temperature_celsius));
  SetPayload();
}

bool U3vCamera::MayBeClaimed() const {
  const std::lock_guard lock(mutex_);
  return !faults_.held;
}

void U3vCamera::Take(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) {
  const std::lock_guard lock(mutex_);
  if (endpoint == kCommandEndpoint) answers_.push_back(Answer(bytes));
}

Bytes U3vCamera::Answer(std::span<const std::uint8_t> command) {
  if (command.size() < kHead_bytes + kAddress_bytes || GetLittle<std::uint32_t>(command, 0) != kCommandMagic) {
    return AnswerTo(0, 0, kInvalidHeader, {});
  }
  const auto kind = GetLittle<std::uint16_t>(command, 6);
  const auto request = GetLittle<std::uint16_t>(command, 10);
  const auto address = GetLittle<std::uint64_t>(command, kHead_bytes);
  const std::span<const std::uint8_t> rest = command.subspan(kHead_bytes + kAddress_bytes);
  std::size_t count = rest.size();
  if (kind == kRead) count = rest.size() >= 4 ? GetLittle<std::uint16_t>(rest, 2) : 0;
  if (kind != kRead && kind != kWrite) return AnswerTo(kind, request, kNotImplemented, {});
  if (address > memory_.size() || count > memory_.size() - address) {
    return AnswerTo(kind, request, kInvalidAddress, {});
  }
  const std::span<std::uint8_t> place = std::span(memory_).subspan(static_cast<std::size_t>(address), count);
  if (kind == kRead) return AnswerTo(kind, request, kGood, place);
  std::ranges::copy(rest, place.begin());
  Written(static_cast<std::size_t>(address));
  const std::array<std::uint8_t, 4> written = {0, 0, static_cast<std::uint8_t>(count & 0xff),
                                               static_cast<std::uint8_t>(count >> 8)};
  return AnswerTo(kind, request, kGood, written);
}

void U3vCamera::Written(std::size_t address) {
  switch (address) {
    case sirm::kControl:
      shots_.clear(), phase_ = Phase::kLeader, next_number_ = 0;
      break;
    case feature::kStart:
      acquiring_ = true;
      break;
    case feature::kStop:  // a picture under way is finished
      acquiring_ = false;
      while (shots_.size() > (phase_ == Phase::kLeader ? 0U : 1U)) shots_.pop_back();
      break;
    case feature::kTriggerSoftware:
      Shoot();
      break;
    case feature::kWidth:
    case feature::kHeight:
    case feature::kPixelFormat:
      SetPayload();
      break;
    default:
      break;
  }
}

void U3vCamera::SetPayload() {
  const std::uint32_t bytes_per_pixel = Get<std::uint32_t>(feature::kPixelFormat) == kMono16 ? 2 : 1;
  const std::uint32_t payload_bytes =
      Get<std::uint32_t>(feature::kWidth) * Get<std::uint32_t>(feature::kHeight) * bytes_per_pixel;
  Put<std::uint32_t>(feature::kPayload_bytes, payload_bytes);
  Put<std::uint64_t>(sirm::kPayload_bytes, payload_bytes);
}

bool U3vCamera::Streaming() const {
  return (Get<std::uint32_t>(sirm::kControl) & sirm::kEnabled) != 0;
}

void U3vCamera::Shoot() {
  if (!acquiring_ || !Streaming() || Get<std::uint32_t>(feature::kTriggerMode) != 1 ||
      Get<std::uint32_t>(feature::kTriggerSource) != 0) {
    return;
  }
  ++num_shots_;
  changed_.notify_all();
  const std::uint64_t number = next_number_++;
  if (faults_.silent) return;
  shots_.push_back({.number = number,
                    .width_px = static_cast<int>(Get<std::uint32_t>(feature::kWidth)),
                    .height_px = static_cast<int>(Get<std::uint32_t>(feature::kHeight)),
                    .bytes_per_pixel = Get<std::uint32_t>(feature::kPixelFormat) == kMono16 ? 2 : 1,
                    .exposure_us = Get<float>(feature::kExposure_us),
                    .gain_db = Get<float>(feature::kGain_db)});
}

Bytes U3vCamera::Leader() const {
  const U3vShot& shot = shots_.front();
  Bytes leader(kLeader_bytes, 0);
  const std::span bytes(leader);
  SetLittle(bytes, 0, kLeaderMagic);
  SetLittle(bytes, 6, static_cast<std::uint16_t>(kLeader_bytes));
  SetLittle(bytes, 8, shot.number);
  SetLittle<std::uint16_t>(bytes, 18, 1);  // an image
  SetLittle(bytes, 20, Now_ns());
  SetLittle(bytes, 28, shot.bytes_per_pixel == 2 ? kMono16 : kMono8);
  SetLittle(bytes, 32, static_cast<std::uint32_t>(shot.width_px));
  SetLittle(bytes, 36, static_cast<std::uint32_t>(shot.height_px));
  SetLittle(bytes, 40, Get<std::uint32_t>(feature::kOffsetX));
  SetLittle(bytes, 44, Get<std::uint32_t>(feature::kOffsetY));
  return leader;
}

Bytes U3vCamera::Trailer() const {
  Bytes trailer(kTrailer_bytes, 0);
  const std::span bytes(trailer);
  SetLittle(bytes, 0, kTrailerMagic);
  SetLittle(bytes, 6, static_cast<std::uint16_t>(kTrailer_bytes));
  SetLittle(bytes, 8, shots_.front().number);
  SetLittle(bytes, 20, static_cast<std::uint64_t>(sent_bytes_));
  SetLittle(bytes, 28, static_cast<std::uint32_t>(shots_.front().height_px));
  return trailer;
}

std::size_t U3vCamera::GivePayload(std::span<std::uint8_t> room) {
  std::size_t all = pixels_.total() * pixels_.elemSize();
  if (faults_.truncated) all -= std::min(all, kLeftOut_bytes);
  const std::size_t count = std::min(room.size(), all - std::min(all, sent_bytes_));
  std::memcpy(room.data(), pixels_.data + sent_bytes_, count);
  sent_bytes_ += count;
  if (sent_bytes_ >= all) phase_ = Phase::kTrailer;
  return count;
}

std::optional<std::size_t> U3vCamera::Give(std::uint8_t endpoint, std::span<std::uint8_t> room) {
  const std::lock_guard lock(mutex_);
  const auto give = [&](const Bytes& bytes) {
    const std::size_t count = std::min(room.size(), bytes.size());
    std::copy_n(bytes.begin(), count, room.begin());
    return count;
  };
  if (endpoint == kAnswerEndpoint && !answers_.empty()) {
    const std::size_t count = give(answers_.front());
    answers_.pop_front();
    return count;
  }
  if (endpoint != kStreamEndpoint || !Streaming() || shots_.empty()) return std::nullopt;
  if (phase_ == Phase::kLeader) {
    pixels_ = source_(shots_.front()).clone();
    Ensure(pixels_.total() * pixels_.elemSize() == static_cast<std::size_t>(shots_.front().width_px) *
                                                       shots_.front().height_px * shots_.front().bytes_per_pixel,
           "the picture source gives what the camera is set to");
    sent_bytes_ = 0;
    phase_ = Phase::kPayload;
    return give(Leader());
  }
  if (faults_.stalls_after_bytes && sent_bytes_ >= *faults_.stalls_after_bytes) {
    stalled_ = true;
    changed_.notify_all();
    return std::nullopt;
  }
  if (phase_ == Phase::kPayload) return GivePayload(room);
  const std::size_t count = give(Trailer());
  shots_.pop_front();
  phase_ = Phase::kLeader;
  return count;
}

}  // namespace rigcal::sim
