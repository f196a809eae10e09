#include "tests/drivers/scripted_devices.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "core/base/random.h"

namespace rigcal {

cv::Mat TexturedPicture(int seed) {
  Random random(static_cast<std::uint64_t>(seed));
  cv::Mat1b picture(48, 64);
  for (auto& pixel : picture) pixel = static_cast<std::uint8_t>(random.Uniform(20, 230));
  cv::GaussianBlur(picture, picture, cv::Size(), 0.8);
  return picture;
}

ScriptedCamera::ScriptedCamera(std::string id, FakeClock& clock, std::vector<std::string>& log,
                               std::string pixel_format)
    : identity_{.id = std::move(id), .width_px = 64, .height_px = 48, .pixel_format = std::move(pixel_format)},
      clock_(clock),
      log_(log) {}

Result<void> ScriptedCamera::Answers() {
  if (clock_.NowS() >= gone_from_s && clock_.NowS() < gone_until_s) connected_ = false;
  if (connected_) return {};
  return Fail(ErrorCode::kDevice, "camera '{}': connection lost", identity_.id);
}

Result<void> ScriptedCamera::MakeReady(const std::stop_token& stop) {
  log_.push_back("ready " + identity_.id);
  if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "stopped");
  return Answers();
}

Result<void> ScriptedCamera::Fire() {
  log_.push_back("fire " + identity_.id);
  ++shot_;
  fired_s_ = clock_.NowS();
  return Answers();
}

Result<CapturedPicture> ScriptedCamera::Collect(double timeout_s, const std::stop_token& stop) {
  log_.push_back("collect " + identity_.id);
  if (shot_ == throws_at_shot) throw std::runtime_error("a bug in a driver");
  const auto found = script.find(shot_);
  const ShotKind kind = found == script.end() ? ShotKind::kGood : found->second;
  const bool comes = kind != ShotKind::kMissing && Answers();
  const double wait_s = comes ? std::max(0.0, fired_s_ + kExposure_s - clock_.NowS()) : timeout_s;
  if (!clock_.Wait(wait_s, stop)) return Fail(ErrorCode::kCancelled, "camera '{}': stopped", identity_.id);
  if (!comes) return Fail(ErrorCode::kTimeout, "camera '{}': no picture within {} s", identity_.id, timeout_s);
  if (kind == ShotKind::kIncomplete) return Fail(ErrorCode::kDevice, "camera '{}': incomplete", identity_.id);
  cv::Mat picture = TexturedPicture(seed + shot_);
  if (kind == ShotKind::kSaturated) picture.rowRange(0, 36).setTo(255);
  if (kind == ShotKind::kDark) picture.setTo(1);
  if (kind == ShotKind::kBlurred) cv::GaussianBlur(picture, picture, cv::Size(), 4);
  if (kind == ShotKind::kSame) picture = last_.clone();
  last_ = picture;
  return CapturedPicture{.pixels = picture.clone(), .number = static_cast<std::uint64_t>(shot_)};
}

Result<void> ScriptedCamera::Restore(double timeout_s, const std::stop_token& stop) {
  log_.push_back("restore " + identity_.id);
  if (Answers()) return {};
  const double back_s = std::max(0.0, gone_until_s - clock_.NowS());
  if (!clock_.Wait(std::min(back_s, timeout_s), stop)) return Fail(ErrorCode::kCancelled, "stopped");
  if (back_s > timeout_s) {
    return Fail(ErrorCode::kDevice, "camera '{}': not back within {} s", identity_.id, timeout_s);
  }
  connected_ = true;
  return {};
}

Result<void> ScriptedPositioner::Home(const std::stop_token& stop) {
  log_.push_back("home");
  if (!clock_.Wait(kMove_s, stop)) return Fail(ErrorCode::kCancelled, "stopped");
  return {};
}

Result<RecordedStop> ScriptedPositioner::MoveTo(const StopTarget& target, const std::stop_token& stop) {
  log_.push_back("move " + target.id);
  if (on_move) on_move(target.id);
  stop_ = target.id;
  moving = true;
  const bool in_time = clock_.Wait(kMove_s, stop);
  if (!in_time) return Fail(ErrorCode::kCancelled, "the move was stopped");
  if (target.id == failing_stop) return Fail(ErrorCode::kDevice, "table: alarm on the way to '{}'", target.id);
  moving = false;
  return RecordedStop{.id = target.id, .axes = {{.axis = "table", .commanded = target.axes.front()}}};
}

Result<std::optional<RecordedStop>> ScriptedPositioner::NextStop(const std::stop_token& stop) {
  if (next_told_ == told.size()) return std::optional<RecordedStop>();
  const RecordedStop& next = told[next_told_];
  const Result<RecordedStop> moved = MoveTo({next.id, {0}}, stop);
  if (!moved) return Fail(moved.error());
  ++next_told_;
  return std::optional(next);
}

Result<void> ScriptedPositioner::FinishStop(const Result<void>& taken) {
  finished.push_back(stop_ + " " + (taken ? "good" : taken.error().message));
  return {};
}

void ScriptedPositioner::Halt() noexcept {
  moving = false;
  ++num_halts;
}

}  // namespace rigcal
