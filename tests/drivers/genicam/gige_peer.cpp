#include "tests/drivers/genicam/gige_peer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <utility>

#include "drivers/genicam/genicam_driver.h"

namespace rigcal {
namespace {

constexpr int kPacket_bytes = 4000;  ///< configured: negotiating takes longer than all the rest of opening
constexpr double kPoll_s = 0.002;
constexpr double kAnswer_s = 2;     ///< the camera's thread may be held up as well
constexpr double kRetention_s = 1;  ///< small frames come within milliseconds; a busy machine may hold them up

sim::GigeDeviceOptions Small(sim::GigeDeviceOptions options) {
  // Searches of another test program that runs at once must not find it.
  options.camera.serial = fmt::format("SIM-{}", getpid());
  options.camera.width_px = GigePeer::kWidth_px;
  options.camera.height_px = GigePeer::kHeight_px;
  return options;
}

}  // namespace

std::unique_ptr<GigePeer> GigePeer::Start(sim::GigeDeviceOptions options) {
  std::unique_ptr<GigePeer> peer(new GigePeer);
  auto device = sim::GigeDevice::Start(Small(std::move(options)), [raw = peer.get()](const sim::GigeShot& shot) {
    const std::lock_guard lock(raw->mutex_);
    return raw->source_(shot);
  });
  if (device) {
    peer->device_ = std::move(*device);
    return peer;
  }
  std::cerr << device.error().message << '\n';
  if (std::getenv("RIGCAL_NEEDS_PEERS") != nullptr) ADD_FAILURE() << device.error().message;
  return nullptr;
}

GigePeer::GigePeer() {
  options_.answer_s = kAnswer_s;
  options_.frame_retention_s = kRetention_s;
  options_.abandoned_s = 0;  // who holds the camera here will not let it go
  options_.reach = GigeReach::kThisMachine;
  Show([this](const sim::GigeShot& shot) {
    const cv::Mat sensor = Pattern(shown_, kWidth_px, kHeight_px, shot.format.bits);
    return cv::Mat(sensor, cv::Rect(shot.left_px, shot.top_px, shot.width_px, shot.height_px)).clone();
  });
}

void GigePeer::Show(sim::GigePictureSource source) {
  const std::lock_guard lock(mutex_);
  source_ = std::move(source);
}

GigePeer::~GigePeer() {
  other_.reset();
  later_.clear();  // they use the device
}

cv::Mat GigePeer::Pattern(int shot, int width_px, int height_px, int bits) {
  cv::Mat picture(height_px, width_px, bits > 8 ? CV_16U : CV_8U);
  std::uint32_t state = 977u * static_cast<std::uint32_t>(shot) + 1;
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      state = state * 1664525u + 1013904223u;  // every byte of every packet says which shot it is of
      const std::uint32_t value = state >> (32 - bits);
      if (bits > 8) picture.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(value);
      if (bits <= 8) picture.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(value);
    }
  }
  return picture;
}

void GigePeer::After(double seconds, std::function<void()> action) {
  later_.emplace_back([this, seconds, action = std::move(action)](const std::stop_token& stop) {
    if (clock_.Wait(seconds, stop)) action();
  });
}

std::stop_token GigePeer::StopAfter(double seconds) {
  std::stop_source source;
  After(seconds, [source]() mutable { source.request_stop(); });
  return source.get_token();
}

CameraSettings GigePeer::Settings() {
  return {.id = "left",
          .driver = "genicam",
          .serial = device_->Serial(),
          .address = device_->Address(),
          .packet_bytes = kPacket_bytes};
}

Result<std::unique_ptr<CameraDevice>> GigePeer::Open(const CameraSettings& settings) {
  const auto tell = [this](const std::string& sentence) { told_.push_back(sentence); };
  return MakeGenicamDriver(options_, {.clock = &clock_, .tell = tell})->OpenCamera(settings, {});
}

std::optional<std::string> GigePeer::WhyNot(CameraFault /*fault*/) {
  return std::nullopt;
}

void GigePeer::Fault(const std::function<void(sim::GigeFaults&)>& change) {
  sim::GigeFaults faults = device_->Faults();
  change(faults);
  device_->Set(faults);
}

void GigePeer::Set(CameraFault fault, bool on) {
  if (fault == CameraFault::kSilent) Fault([&](auto& faults) { faults.silent = on; });
  if (fault == CameraFault::kDamaged) Fault([&](auto& faults) { faults.truncated = on; });
  if (fault == CameraFault::kGone && on) device_->Kill();
  if (fault == CameraFault::kGone && !on) (void)device_->Revive();
  if (fault == CameraFault::kHeldByOther) other_.reset();
  if (fault == CameraFault::kHeldByOther && on) other_ = *Open();
}

void GigePeer::GoneFor(double seconds) {
  device_->Kill();
  After(seconds, [this] { (void)device_->Revive(); });
}

bool GigePeer::Await(const std::function<bool(const sim::GigeCounts&)>& wanted) {
  const double end_s = clock_.NowS() + kHang_s;
  while (!wanted(device_->Counts())) {
    if (clock_.NowS() > end_s) return false;
    clock_.Wait(kPoll_s, {});
  }
  return true;
}

}  // namespace rigcal
