#include "sim_fixtures/gige/gige_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "sim_fixtures/gige/gige_registers.h"

namespace rigcal::sim {
namespace {

constexpr std::size_t kMostMemory_bytes = 536;  ///< of one memory command
constexpr std::uint32_t kVersion1_2 = 0x00010002, kBigEndianUtf8 = 0x80000001, kLoopbackMask = 0xff000000;
constexpr std::uint32_t kLocallyAdministered = 0x0200;
constexpr std::uint32_t kDefaultHeartbeat_ms = 3000, kDefaultPacket_bytes = 1500;
constexpr std::uint32_t kTicksPerSecond = 1'000'000'000;
constexpr float kDefaultExposure_us = 10000;

std::uint32_t MostOffset(std::uint32_t sensor, std::uint32_t size) {
  return sensor - std::min(size, sensor);
}

}  // namespace

GigeCamera::GigeCamera(const GigeCameraSpec& spec, const GigeEndpoint& stream_source, bool can_resend) : spec_(spec) {
  const auto set = [this](std::uint32_t address, std::uint32_t value) { memory_.SetNumber(address, value); };
  set(bootstrap::kVersion, kVersion1_2);
  set(bootstrap::kDeviceMode, kBigEndianUtf8);
  set(bootstrap::kMacHigh, kLocallyAdministered);
  set(bootstrap::kMacLow, stream_source.ip);  // one camera per address
  set(bootstrap::kCurrentIp, stream_source.ip);
  set(bootstrap::kCurrentSubnet, kLoopbackMask);
  memory_.SetText(bootstrap::kVendor, "rigcal");
  memory_.SetText(bootstrap::kModel, spec.model);
  memory_.SetText(bootstrap::kFirmware, spec.firmware);
  memory_.SetText(bootstrap::kSerial, spec.serial);
  const std::string xml = GenicamXml(spec.limits);
  memory_.SetText(own::kXml, xml);
  memory_.SetText(bootstrap::kXmlUrl, fmt::format("Local:studio.xml;{:x};{:x}", own::kXml, xml.size()));
  set(bootstrap::kNumInterfaces, 1);
  set(bootstrap::kNumStreams, 1);
  set(bootstrap::kCapabilities,
      bootstrap::kCanConcatenate | bootstrap::kCanWriteMemory | (can_resend ? bootstrap::kCanResend : 0));
  set(bootstrap::kHeartbeat_ms, kDefaultHeartbeat_ms);
  set(bootstrap::kTickFrequencyLow, spec.has_clock ? kTicksPerSecond : 0);
  set(bootstrap::kStreamPacket, kDefaultPacket_bytes);
  set(bootstrap::kStreamSourcePort, stream_source.port);
  set(own::kSensorWidth, spec.width_px);
  set(own::kSensorHeight, spec.height_px);
  set(own::kWidth, spec.width_px);
  set(own::kHeight, spec.height_px);
  set(own::kPixelFormat, GigePixelFormats().front().code);
  set(own::kPayload_bytes, static_cast<std::uint32_t>(spec.width_px * spec.height_px));
  memory_.SetFloat(own::kExposure_us, kDefaultExposure_us);
  memory_.SetFloat(own::kGamma, static_cast<float>(spec.gamma));
  memory_.SetFloat(own::kTemperature, static_cast<float>(spec.temperature_celsius));
}

GigeEndpoint GigeCamera::StreamTarget() const {
  return {memory_.Number(bootstrap::kStreamIp), static_cast<std::uint16_t>(memory_.Number(bootstrap::kStreamPort))};
}

void GigeCamera::ForgetStreamTarget() {
  memory_.SetNumber(bootstrap::kStreamPort, 0);
}

int GigeCamera::Packet_bytes() const {
  return static_cast<int>(memory_.Number(bootstrap::kStreamPacket) & bootstrap::kPacketSizeMask);
}

void GigeCamera::SetController(const std::optional<GigeEndpoint>& controller, bool exclusive, double now_s) {
  controller_ = controller;
  controller_spoke_s_ = now_s;
  acquiring_ = false;
  const GigeEndpoint named = controller.value_or(GigeEndpoint{});
  memory_.SetNumber(bootstrap::kControllerIp, named.ip);
  memory_.SetNumber(bootstrap::kControllerPort, named.port);
  const std::uint32_t access = exclusive ? bootstrap::kExclusiveAccess : bootstrap::kControlAccess;
  memory_.SetNumber(bootstrap::kControl, controller ? access : 0);
}

void GigeCamera::Elapse(double now_s) {
  const double heartbeat_s = memory_.Number(bootstrap::kHeartbeat_ms) / 1000.0;
  if (controller_ && now_s - controller_spoke_s_ > heartbeat_s) SetController(std::nullopt, false, now_s);
}

bool GigeCamera::MayRead(const GigeEndpoint& from) const {
  return controller_ == from || (memory_.Number(bootstrap::kControl) & bootstrap::kExclusiveAccess) == 0;
}

bool GigeCamera::MayWrite(const GigeEndpoint& from, std::uint32_t address) const {
  return controller_ ? controller_ == from : address == bootstrap::kControl;
}

GigeReaction GigeCamera::Receive(std::span<const std::uint8_t> datagram, const GigeEndpoint& from, double now_s) {
  const std::optional<GvcpRequest> request = ParseGvcp(datagram);
  if (!request) return {};
  Elapse(now_s);
  if (controller_ == from) controller_spoke_s_ = now_s;
  GigeReaction reaction;
  Bytes answer;
  GvcpStatus status = GvcpStatus::kNotImplemented;
  switch (request->command) {
    case GvcpCommand::kDiscovery: {
      const auto told = memory_.Read(0, bootstrap::kDiscovery_bytes);
      answer.assign(told.begin(), told.end());
      status = GvcpStatus::kSuccess;
      break;
    }
    case GvcpCommand::kPacketResend:
      if (request->payload.size() < 12) return {};
      reaction.resend = GigeResend{.frame = static_cast<std::uint16_t>(GetBigEndian(request->payload.subspan(2, 2))),
                                   .first = static_cast<std::uint32_t>(GetBigEndian(request->payload.subspan(5, 3))),
                                   .last = static_cast<std::uint32_t>(GetBigEndian(request->payload.subspan(9, 3)))};
      return reaction;  // it is answered by the packets
    case GvcpCommand::kReadRegister:
      status = MayRead(from) ? ReadRegisters(*request, answer) : GvcpStatus::kAccessDenied;
      break;
    case GvcpCommand::kReadMemory:
      status = MayRead(from) ? ReadMemory(*request, answer) : GvcpStatus::kAccessDenied;
      break;
    case GvcpCommand::kWriteRegister:
      status = WriteRegisters(*request, from, now_s, answer, reaction);
      break;
    case GvcpCommand::kWriteMemory:
      status = WriteMemory(*request, from, now_s, answer, reaction);
      break;
  }
  if (request->wants_answer) reaction.answer = GvcpAnswer(*request, status, answer);
  return reaction;
}

GvcpStatus GigeCamera::ReadRegisters(const GvcpRequest& request, Bytes& answer) const {
  for (std::size_t at = 0; at + 4 <= request.payload.size(); at += 4) {
    const auto address = static_cast<std::uint32_t>(GetBigEndian(request.payload.subspan(at, 4)));
    if (address % 4 != 0) return GvcpStatus::kBadAlignment;
    if (!memory_.Holds(address, 4)) return GvcpStatus::kInvalidAddress;
    PutBigEndian(answer, memory_.Number(address), 4);
  }
  return GvcpStatus::kSuccess;
}

GvcpStatus GigeCamera::ReadMemory(const GvcpRequest& request, Bytes& answer) const {
  if (request.payload.size() < 8) return GvcpStatus::kInvalidParameter;
  const auto address = static_cast<std::uint32_t>(GetBigEndian(request.payload.first(4)));
  const std::size_t size = GetBigEndian(request.payload.subspan(6, 2));
  if (size > kMostMemory_bytes) return GvcpStatus::kInvalidParameter;
  if (!memory_.Holds(address, size)) return GvcpStatus::kInvalidAddress;
  PutBigEndian(answer, address, 4);
  const auto bytes = memory_.Read(address, size);
  answer.insert(answer.end(), bytes.begin(), bytes.end());
  return GvcpStatus::kSuccess;
}

GvcpStatus GigeCamera::WriteRegisters(const GvcpRequest& request, const GigeEndpoint& from, double now_s, Bytes& answer,
                                      GigeReaction& reaction) {
  std::uint32_t num_written = 0;
  GvcpStatus status = GvcpStatus::kSuccess;
  for (std::size_t at = 0; at + 8 <= request.payload.size() && status == GvcpStatus::kSuccess; at += 8) {
    const auto address = static_cast<std::uint32_t>(GetBigEndian(request.payload.subspan(at, 4)));
    const auto value = static_cast<std::uint32_t>(GetBigEndian(request.payload.subspan(at + 4, 4)));
    status = Write(address, value, from, now_s, reaction);
    if (status == GvcpStatus::kSuccess) ++num_written;
  }
  PutBigEndian(answer, num_written, 4);
  return status;
}

GvcpStatus GigeCamera::WriteMemory(const GvcpRequest& request, const GigeEndpoint& from, double now_s, Bytes& answer,
                                   GigeReaction& reaction) {
  if (request.payload.size() < 8) return GvcpStatus::kInvalidParameter;
  const auto address = static_cast<std::uint32_t>(GetBigEndian(request.payload.first(4)));
  for (std::size_t at = 4; at + 4 <= request.payload.size(); at += 4) {
    const auto value = static_cast<std::uint32_t>(GetBigEndian(request.payload.subspan(at, 4)));
    const auto status = Write(address + static_cast<std::uint32_t>(at) - 4, value, from, now_s, reaction);
    if (status != GvcpStatus::kSuccess) return status;
  }
  PutBigEndian(answer, request.payload.size() - 4, 4);
  return GvcpStatus::kSuccess;
}

void GigeCamera::LatchTime(double now_s) {
  const auto ticks = static_cast<std::uint64_t>(now_s * kTicksPerSecond);
  memory_.SetNumber(bootstrap::kTimeHigh, static_cast<std::uint32_t>(ticks >> 32));
  memory_.SetNumber(bootstrap::kTimeLow, static_cast<std::uint32_t>(ticks));
}

/// Whether a value is within what the description promises.
bool GigeCamera::Fits(std::uint32_t address, std::uint32_t value) const {
  const GigeLimits& limits = spec_.limits;
  const auto size_fits = [&](int sensor_px) {
    return value > 0 && value <= static_cast<std::uint32_t>(sensor_px) && value % limits.region_step_px == 0;
  };
  const auto offset_fits = [&](std::uint32_t sensor, std::uint32_t size) {
    return value <= MostOffset(memory_.Number(sensor), memory_.Number(size)) && value % limits.region_step_px == 0;
  };
  const auto real_fits = [&](double least, double most) {
    const double real = std::bit_cast<float>(value);
    return real >= least && real <= most;
  };
  switch (address) {
    case own::kWidth:
      return size_fits(spec_.width_px);
    case own::kHeight:
      return size_fits(spec_.height_px);
    case own::kOffsetX:
      return offset_fits(own::kSensorWidth, own::kWidth);
    case own::kOffsetY:
      return offset_fits(own::kSensorHeight, own::kHeight);
    case own::kPixelFormat:
      return FindGigePixelFormat(value).has_value();
    case own::kExposure_us:
      return real_fits(limits.least_exposure_us, limits.most_exposure_us);
    case own::kGain_db:
      return real_fits(limits.least_gain_db, limits.most_gain_db);
    case bootstrap::kStreamPacket: {
      const auto bytes = static_cast<int>(value & bootstrap::kPacketSizeMask);
      return bytes >= limits.least_packet_bytes && bytes <= limits.most_packet_bytes &&
             bytes % limits.packet_step_bytes == 0;
    }
    default:
      return true;
  }
}

GvcpStatus GigeCamera::Write(std::uint32_t address, std::uint32_t value, const GigeEndpoint& from, double now_s,
                             GigeReaction& reaction) {
  if (address % 4 != 0) return GvcpStatus::kBadAlignment;
  if (!memory_.Holds(address, 4)) return GvcpStatus::kInvalidAddress;
  if (!MayWrite(from, address)) return GvcpStatus::kAccessDenied;
  if (!Fits(address, value)) return GvcpStatus::kInvalidParameter;
  switch (address) {
    case bootstrap::kControl:
      SetController(value != 0 ? std::optional(from) : std::nullopt, (value & bootstrap::kExclusiveAccess) != 0, now_s);
      return GvcpStatus::kSuccess;
    case bootstrap::kTimeControl:
      if ((value & bootstrap::kLatchTime) != 0) LatchTime(now_s);
      return GvcpStatus::kSuccess;
    case own::kSensorWidth:
    case own::kSensorHeight:
    case own::kPayload_bytes:
    case own::kTemperature:
      return GvcpStatus::kWriteProtect;
    case own::kStart:
      acquiring_ = true;
      last_shot_ = 0;
      return GvcpStatus::kSuccess;
    case own::kStop:
      acquiring_ = false;
      return GvcpStatus::kSuccess;
    case own::kTriggerSoftware:
      reaction.shot = Shoot(own::kSoftwareSource, now_s);
      return GvcpStatus::kSuccess;
    case bootstrap::kStreamPacket:
      reaction.test_packet = (value & bootstrap::kFireTestPacket) != 0;
      value &= ~bootstrap::kFireTestPacket;
      break;
    default:
      break;
  }
  memory_.SetNumber(address, value);
  const std::uint32_t pixels = memory_.Number(own::kWidth) * memory_.Number(own::kHeight);
  const int pixel_bytes = FindGigePixelFormat(memory_.Number(own::kPixelFormat))->BytesPerPixel();
  memory_.SetNumber(own::kPayload_bytes, pixels * pixel_bytes);
  return GvcpStatus::kSuccess;
}

std::optional<GigeShot> GigeCamera::Pulse(double now_s) {
  return Shoot(own::kLine1Source, now_s);
}

std::optional<GigeShot> GigeCamera::Shoot(std::uint32_t trigger_source, double now_s) {
  if (!acquiring_ || memory_.Number(own::kTriggerMode) == 0) return std::nullopt;
  if (memory_.Number(own::kTriggerSource) != trigger_source) return std::nullopt;
  last_shot_ = last_shot_ == std::numeric_limits<std::uint16_t>::max() ? 1 : last_shot_ + 1;  // 0 is none
  return GigeShot{.number = last_shot_,
                  .left_px = static_cast<int>(memory_.Number(own::kOffsetX)),
                  .top_px = static_cast<int>(memory_.Number(own::kOffsetY)),
                  .width_px = static_cast<int>(memory_.Number(own::kWidth)),
                  .height_px = static_cast<int>(memory_.Number(own::kHeight)),
                  .format = *FindGigePixelFormat(memory_.Number(own::kPixelFormat)),
                  .exposure_us = memory_.Float(own::kExposure_us),
                  .gain_db = memory_.Float(own::kGain_db),
                  .taken_s = now_s};
}

}  // namespace rigcal::sim
