#include "drivers/replay/replay_driver.h"

#include <algorithm>
#include <utility>

#include "core/base/ensure.h"
#include "drivers/replay/replayed_rig.h"

namespace rigcal {
namespace {

/// A camera of the recording. A shot is the place in the recording at which it was fired.
class ReplayCamera final : public CameraDevice {
 public:
  ReplayCamera(std::shared_ptr<ReplayedRig> rig, int camera) : rig_(std::move(rig)), camera_(camera) {}

  [[nodiscard]] const RecordedCamera& Identity() const override { return rig_->Content().cameras[camera_]; }

  [[nodiscard]] bool Linear() const override { return rig_->Content().linear; }

  Result<void> MakeReady(const std::stop_token& stop) override {
    fired_at_.reset();
    if (stop.stop_requested()) return Stopped();
    return {};
  }

  Result<void> Fire() override {
    fired_at_ = rig_->CurrentStop();
    ++number_;
    if (fired_at_) return {};
    return Fail(ErrorCode::kDevice, "camera '{}': the replay has not reached a stop yet", Identity().id);
  }

  Result<CapturedPicture> Collect(double timeout_s, const std::stop_token& stop) override {
    if (!fired_at_) rig_->Time().Wait(timeout_s, stop);
    if (stop.stop_requested()) return Stopped();
    if (!fired_at_) {
      return Fail(ErrorCode::kTimeout, "camera '{}': no picture within {:.1f} s, it was not fired", Identity().id,
                  timeout_s);
    }
    Result<CapturedPicture> picture = rig_->PictureAt(camera_, *std::exchange(fired_at_, std::nullopt));
    if (picture) picture->number = number_;
    return picture;
  }

  /// What a recording lacks does not come back: trying again shows it again.
  Result<void> Restore(double /*timeout_s*/, const std::stop_token& stop) override {
    if (stop.stop_requested()) return Stopped();
    return {};
  }

 private:
  [[nodiscard]] tl::unexpected<Error> Stopped() const {
    return Fail(ErrorCode::kCancelled, "camera '{}': the replay was stopped on request", Identity().id);
  }

  std::shared_ptr<ReplayedRig> rig_;
  int camera_;
  std::optional<int> fired_at_;
  std::uint64_t number_ = 0;
};

class ReplayPositioner final : public PositionerDevice {
 public:
  ReplayPositioner(std::shared_ptr<ReplayedRig> rig, std::vector<AxisSettings> axes)
      : rig_(std::move(rig)), axes_(std::move(axes)) {}

  Result<void> Home(const std::stop_token& stop) override {
    if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "replay: homing was stopped on request");
    return {};
  }

  Result<RecordedStop> MoveTo(const StopTarget& target, const std::stop_token& stop) override {
    if (!target.axes.empty()) {
      if (Result<void> valid = CheckTarget(target, axes_, "replay"); !valid) return Fail(valid.error());
    }
    const Result<int> found = rig_->FindStop(target);
    if (!found) return Fail(found.error());
    if (Result<void> there = rig_->GoTo(*found, stop); !there) return Fail(there.error());
    RecordedStop reached = rig_->Content().stops[*found];
    reached.id = target.id;
    return reached;
  }

  /// The recording's stops in its order.
  Result<std::optional<RecordedStop>> NextStop(const std::stop_token& stop) override {
    const std::vector<RecordedStop>& stops = rig_->Content().stops;
    if (next_ == static_cast<int>(stops.size())) return std::optional<RecordedStop>();
    if (Result<void> there = rig_->GoTo(next_, stop); !there) return Fail(there.error());
    return std::optional(stops[next_++]);
  }

  Result<void> FinishStop(const Result<void>& /*taken*/) override { return {}; }
  void Halt() noexcept override {}  // nothing moves

 private:
  std::shared_ptr<ReplayedRig> rig_;
  std::vector<AxisSettings> axes_;
  int next_ = 0;  ///< of NextStop
};

class ReplayDriver final : public Driver {
 public:
  explicit ReplayDriver(std::shared_ptr<ReplayedRig> rig) : rig_(std::move(rig)) {}

  Result<std::unique_ptr<CameraDevice>> OpenCamera(const CameraSettings& settings,
                                                   const std::stop_token& /*stop*/) override {
    const std::vector<RecordedCamera>& cameras = rig_->Content().cameras;
    const auto camera = std::ranges::find(cameras, settings.id, &RecordedCamera::id);
    if (camera == cameras.end()) {
      return Fail(ErrorCode::kNotFound, "camera '{}': the recording '{}' has no such camera", settings.id,
                  rig_->Content().id);
    }
    if (!settings.serial.empty() && settings.serial != camera->serial) {
      return Fail(ErrorCode::kNotFound, "camera '{}': has the serial number '{}' in the recording '{}', not '{}'",
                  settings.id, camera->serial, rig_->Content().id, settings.serial);
    }
    return std::make_unique<ReplayCamera>(rig_, static_cast<int>(camera - cameras.begin()));
  }

  Result<std::unique_ptr<PositionerDevice>> OpenPositioner(const PositionerSettings& settings,
                                                           const std::stop_token& /*stop*/) override {
    std::vector<AxisSettings> axes = settings.axes;
    const std::vector<RecordedStop>& stops = rig_->Content().stops;
    if (axes.empty() && !stops.empty()) {
      for (const AxisPosition& axis : stops.front().axes) axes.push_back({.name = axis.axis, .unit = axis.unit});
    }
    for (const RecordedStop& stop : stops) {
      const bool same = std::ranges::equal(stop.axes, axes, [](const AxisPosition& recorded, const AxisSettings& axis) {
        return recorded.axis == axis.name && recorded.unit == axis.unit;
      });
      if (!same) {
        return Fail(ErrorCode::kBadInput, "replay: stop '{}' of the recording '{}' has other axes than the rig",
                    stop.id, rig_->Content().id);
      }
    }
    return std::make_unique<ReplayPositioner>(rig_, std::move(axes));
  }

 private:
  std::shared_ptr<ReplayedRig> rig_;
};

}  // namespace

Result<std::unique_ptr<Driver>> MakeReplayDriver(const RigHardware& rig, const DriverContext& context,
                                                 const std::stop_token& /*stop*/) {
  Ensure(context.clock != nullptr && context.open_recording != nullptr, "a replay needs a clock and its recording");
  if (rig.replay.recording.empty()) {
    return Fail(ErrorCode::kBadInput, "the rig has devices of the driver replay, but names no recording for them");
  }
  Result<RecordedPictures> pictures = context.open_recording(rig.replay.recording);
  if (!pictures) return Fail(pictures.error());
  const auto alone =
      std::ranges::find_if(pictures->recording.views, [](const RecordedView& view) { return !view.stop.has_value(); });
  if (alone != pictures->recording.views.end()) {
    return Fail(ErrorCode::kUnsupported, "{}: the picture '{}' belongs to no stop; only stops can be replayed",
                rig.replay.recording, alone->file);
  }
  return std::make_unique<ReplayDriver>(std::make_shared<ReplayedRig>(std::move(*pictures), context.subject,
                                                                      rig.replay.at_recorded_speed, *context.clock));
}

}  // namespace rigcal
