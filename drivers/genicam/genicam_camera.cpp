#include "drivers/genicam/genicam_camera.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace rigcal {
namespace {

constexpr double kSlice_s = 0.02;                           ///< between two looks at the clock and the stop token
constexpr double kFirstPause_s = 0.1, kLongestPause_s = 1;  ///< between two tries to connect
constexpr double kQuiet_s = 0.1;  ///< nothing has come for so long: what a camera still sent has arrived
constexpr double kLongestQuietWait_s = 2;
constexpr double kSecond_us = 1e6, kSecond_ns = 1e9;
constexpr guint64 kTimeControl = 0x944, kTimeHigh = 0x948, kTimeLow = 0x94c;  ///< bootstrap registers
constexpr guint32 kLatchTime = 2;

std::optional<double> ReadReal(ArvCamera* camera, const char* feature, GLibError& error) {
  if (error.Happened() || arv_camera_is_feature_available(camera, feature, error.Take()) == FALSE) return std::nullopt;
  const double value = arv_camera_get_float(camera, feature, error.Take());
  return error.Happened() ? std::nullopt : std::optional(value);
}

}  // namespace

Result<std::unique_ptr<CameraDevice>> GenicamCamera::Open(const CameraSettings& settings, const GenicamOptions& options,
                                                          const std::function<void(const std::string&)>& tell,
                                                          Clock& clock, const std::stop_token& stop) {
  if (settings.serial.empty() && settings.address.empty()) {
    return Fail(ErrorCode::kBadInput, "camera '{}': the driver genicam needs its serial number or its address",
                settings.id);
  }
  const std::optional<PixelLayout> layout = LayoutOf(settings.pixel_format);
  if (!layout) {
    return Fail(ErrorCode::kUnsupported,
                "camera '{}': pixel_format is \"{}\", pictures are made of unpacked Mono and "
                "Bayer formats with 8, 10, 12 or 16 bits",
                settings.id, settings.pixel_format);
  }
  std::unique_ptr<GenicamCamera> camera(new GenicamCamera(settings, options, *layout, clock));
  if (Result<void> connected = camera->Connect(stop); !connected) return Fail(connected.error());
  if (!camera->path_.warning.empty() && tell) tell(fmt::format("camera '{}': {}", settings.id, camera->path_.warning));
  return camera;
}

GenicamCamera::GenicamCamera(const CameraSettings& settings, const GenicamOptions& options, const PixelLayout& layout,
                             Clock& clock)
    : settings_(settings), options_(options), layout_(layout), clock_(clock) {}

GenicamCamera::~GenicamCamera() {
  Disconnect();
}

Result<void> GenicamCamera::Connect(const std::stop_token& stop) {
  Disconnect();
  Result<std::unique_ptr<CameraLink>> link = CameraLink::Open(settings_, options_, clock_, stop);
  if (!link) return Fail(link.error());
  Result<CameraFacts> facts = SetUpCamera((*link)->Camera(), settings_);
  if (!facts) return Fail(facts.error());
  if (facts->payload_bytes < PictureBytes(layout_, facts->width_px, facts->height_px)) {
    return Fail(ErrorCode::kDevice, "camera '{}': announces {} bytes for a picture of {} x {} pixels {}", settings_.id,
                facts->payload_bytes, facts->width_px, facts->height_px, settings_.pixel_format);
  }
  link_ = std::move(*link);
  facts_ = *facts;
  const bool network = arv_camera_is_gv_device(link_->Camera()) != FALSE;
  path_ = network ? ChooseReceivePath(facts_.payload_bytes, options_) : ReceivePath{};
  const AnnouncedCamera& announced = link_->Announced();
  GLibError error;
  identity_ = {.id = settings_.id,
               .width_px = facts_.width_px,
               .height_px = facts_.height_px,
               .serial = announced.serial,
               .model = fmt::format("{} {}", announced.vendor, announced.model),
               .lens = settings_.lens,
               .pixel_format = settings_.pixel_format,
               .focus_m = settings_.focus_m,
               .temperature_celsius = ReadReal(link_->Camera(), "DeviceTemperature", error)};
  return StartStream(stop);
}

void GenicamCamera::Disconnect() {
  if (link_ && link_->ClosesLate()) {
    // Aravis waits several times 3 s for answers that do not come. Nobody else shall; it touches nothing of this
    // object.
    std::thread([stream = std::move(stream_), link = std::move(link_)]() mutable {
      stream.reset();
      link.reset();
    }).detach();
  }
  stream_.reset();
  link_.reset();
  awaited_ = stalled_ = false;
}

Result<void> GenicamCamera::StartStream(const std::stop_token& stop) {
  Result<std::unique_ptr<FrameStream>> stream =
      FrameStream::Start(link_->Camera(), facts_.payload_bytes, path_, options_, clock_, stop);
  if (!stream && stop.stop_requested()) return Stopped("making it ready");
  if (!stream) return Fail(ErrorCode::kDevice, "camera '{}': {}", settings_.id, stream.error().message);
  GLibError error;
  arv_camera_start_acquisition(link_->Camera(), error.Take());
  if (error.Happened()) {
    return Fail(ErrorCode::kDevice, "camera '{}': does not begin to acquire: {}", settings_.id, error.Text());
  }
  stream_ = std::move(*stream);
  awaited_ = stalled_ = false;
  return {};
}

Result<void> GenicamCamera::RestartStream(const std::stop_token& stop) {
  GLibError error;
  arv_camera_stop_acquisition(link_->Camera(), error.Take());
  if (error.Happened()) {
    return Fail(ErrorCode::kDevice, "camera '{}': does not end to acquire: {}", settings_.id, error.Text());
  }
  const double quiet_s = kQuiet_s + settings_.exposure_us.value_or(0) / kSecond_us;
  const double begin_s = clock_.NowS();
  double silent_since_s = begin_s;
  std::uint64_t num_received = stream_->NumReceived();
  while (clock_.NowS() - silent_since_s < quiet_s && clock_.NowS() - begin_s < kLongestQuietWait_s + quiet_s) {
    if (!clock_.Wait(kSlice_s, stop)) return Stopped("making it ready");
    if (std::exchange(num_received, stream_->NumReceived()) != stream_->NumReceived()) silent_since_s = clock_.NowS();
  }
  stream_.reset();
  return StartStream(stop);
}

tl::unexpected<Error> GenicamCamera::Stopped(const char* what) const {
  return Fail(ErrorCode::kCancelled, "camera '{}': {} was stopped on request", settings_.id, what);
}

Result<std::uint64_t> GenicamCamera::CameraTime_ns() {
  if (!facts_.has_clock) return std::uint64_t{0};
  ArvDevice* device = arv_camera_get_device(link_->Camera());
  GLibError error;
  guint32 high = 0, low = 0;
  guint64 ticks_per_s = 0;
  if (arv_device_write_register(device, kTimeControl, kLatchTime, error.Take()) == FALSE ||
      arv_device_read_register(device, kTimeHigh, &high, error.Take()) == FALSE ||
      arv_device_read_register(device, kTimeLow, &low, error.Take()) == FALSE ||
      (ticks_per_s = arv_gv_device_get_timestamp_tick_frequency(ARV_GV_DEVICE(device), error.Take())) == 0) {
    return Fail(ErrorCode::kDevice, "camera '{}': does not tell its time: {}", settings_.id, error.Text());
  }
  const auto ticks = static_cast<double>(static_cast<std::uint64_t>(high) << 32 | low);
  return static_cast<std::uint64_t>(ticks / static_cast<double>(ticks_per_s) * kSecond_ns);
}

Result<void> GenicamCamera::MakeReady(const std::stop_token& stop) {
  if (stop.stop_requested()) return Stopped("making it ready");
  if (!link_) return Fail(ErrorCode::kDevice, "camera '{}': the connection is lost", settings_.id);
  if (Result<void> well = link_->Check(stop); !well) return well;
  const bool may_mistake = !facts_.has_clock && (awaited_ || settings_.trigger == CameraTrigger::kHardware);
  if (stalled_ || may_mistake || !stream_) {
    if (Result<void> restarted = RestartStream(stop); !restarted) return restarted;
  }
  while (stream_->Next(0)) {
  }
  Result<std::uint64_t> now_ns = CameraTime_ns();
  if (!now_ns) return Fail(now_ns.error());
  ready_ns_ = *now_ns;
  awaited_ = false;
  return {};
}

Result<void> GenicamCamera::Fire() {
  if (!link_) return Fail(ErrorCode::kDevice, "camera '{}': the connection is lost", settings_.id);
  awaited_ = true;
  if (settings_.trigger == CameraTrigger::kHardware) return {};
  GLibError error;
  arv_camera_software_trigger(link_->Camera(), error.Take());
  if (error.Happened()) {
    return Fail(ErrorCode::kDevice, "camera '{}': does not take the trigger: {}", settings_.id, error.Text());
  }
  return {};
}

Result<CapturedPicture> GenicamCamera::Collect(double timeout_s, const std::stop_token& stop) {
  const double end_s = clock_.NowS() + timeout_s;
  double wait_s = 0;  // what has come already is given whatever timeout_s
  while (link_ && stream_) {
    if (const std::optional<ReceivedFrame> frame = stream_->Next(wait_s)) {
      Result<std::optional<CapturedPicture>> judged = Judge(*frame);
      if (!judged) return Fail(judged.error());
      if (*judged) return std::move(**judged);
      continue;
    }
    if (stop.stop_requested()) return Stopped("waiting for the picture");
    if (link_->ControlLost()) {
      return Fail(ErrorCode::kDevice, "camera '{}' at {}: the control of it is lost", settings_.id,
                  link_->Announced().address);
    }
    const double left_s = end_s - clock_.NowS();
    if (left_s <= 0) {
      stalled_ = awaited_;
      return Fail(ErrorCode::kTimeout, "camera '{}': no picture within {:.1f} s", settings_.id, timeout_s);
    }
    wait_s = std::min(kSlice_s, left_s);
  }
  return Fail(ErrorCode::kDevice, "camera '{}': the connection is lost", settings_.id);
}

Result<std::optional<CapturedPicture>> GenicamCamera::Judge(const ReceivedFrame& frame) {
  if (frame.taken_ns != 0 && frame.taken_ns < ready_ns_) return std::nullopt;  // of an earlier shot
  if (!awaited_) return std::nullopt;                                          // of none
  awaited_ = false;
  ++number_;
  std::string flaw = frame.flaw;
  if (flaw.empty() && (frame.width_px != facts_.width_px || frame.height_px != facts_.height_px ||
                       frame.bytes.size() < PictureBytes(layout_, facts_.width_px, facts_.height_px))) {
    flaw = fmt::format("it has {} x {} pixels in {} bytes instead of {} x {}", frame.width_px, frame.height_px,
                       frame.bytes.size(), facts_.width_px, facts_.height_px);
  }
  if (!flaw.empty()) {
    ++num_incomplete_;
    return Fail(ErrorCode::kDevice, "camera '{}': picture {} came incomplete, the {}. since it was opened: {}",
                settings_.id, number_, num_incomplete_, flaw);
  }
  CapturedPicture picture{.pixels = DecodePicture(layout_, facts_.width_px, facts_.height_px, frame.bytes),
                          .number = number_};
  ReadBack(picture);
  return std::optional(std::move(picture));
}

/// What cannot be read stays unknown: the picture is good all the same.
void GenicamCamera::ReadBack(CapturedPicture& picture) {
  GLibError error;
  ArvCamera* camera = link_->Camera();
  picture.exposure_us = arv_camera_get_exposure_time(camera, error.Take());
  if (error.Happened()) {  // no further questions: each may take Aravis seconds
    picture.exposure_us.reset();
    return;
  }
  picture.gain_db = ReadReal(camera, "Gain", error);
  picture.temperature_celsius = ReadReal(camera, "DeviceTemperature", error);
}

Result<void> GenicamCamera::Restore(double timeout_s, const std::stop_token& stop) {
  const double end_s = clock_.NowS() + timeout_s;
  double pause_s = kFirstPause_s;
  while (!stop.stop_requested()) {
    if (link_ && stream_ && link_->Check(stop)) return {};
    if (stop.stop_requested()) break;
    const Result<void> connected = Connect(stop);
    if (connected) return {};
    const double left_s = end_s - clock_.NowS();
    if (left_s <= 0) {
      return Fail(ErrorCode::kDevice, "{}; it did not come back within {:.1f} s", connected.error().message, timeout_s);
    }
    clock_.Wait(std::min(pause_s, left_s), stop);
    pause_s = std::min(2 * pause_s, kLongestPause_s);
  }
  return Stopped("connecting again");
}

}  // namespace rigcal
