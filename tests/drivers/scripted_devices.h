#pragma once

#include <functional>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera_device.h"
#include "drivers/positioner_device.h"
#include "tests/support/fake_clock.h"

namespace rigcal {

/// What a scripted camera gives for a shot.
enum class ShotKind { kGood, kSaturated, kDark, kBlurred, kSame, kMissing, kIncomplete };

/// The good picture of a shot: random texture, another for each camera and shot.
cv::Mat TexturedPicture(int seed);

/// A camera that does what the test says, and writes down what it was asked ("fire left").
class ScriptedCamera final : public CameraDevice {
 public:
  ScriptedCamera(std::string id, FakeClock& clock, std::vector<std::string>& log, std::string pixel_format = "Mono8");

  std::map<int, ShotKind> script;                                ///< by shot from 0; good where nothing is said
  double gone_from_s = std::numeric_limits<double>::infinity();  ///< does not answer, until it is
  double gone_until_s = std::numeric_limits<double>::infinity();
  int throws_at_shot = -1;  ///< collecting this one throws
  int seed = 0;             ///< of its pictures: TexturedPicture(seed + shot)
  bool linear = true;
  static constexpr double kExposure_s = 0.1;

  [[nodiscard]] const RecordedCamera& Identity() const override { return identity_; }
  [[nodiscard]] bool Linear() const override { return linear; }
  Result<void> MakeReady(const std::stop_token& stop) override;
  Result<void> Fire() override;
  Result<CapturedPicture> Collect(double timeout_s, const std::stop_token& stop) override;
  Result<void> Restore(double timeout_s, const std::stop_token& stop) override;

 private:
  Result<void> Answers();

  RecordedCamera identity_;
  FakeClock& clock_;
  std::vector<std::string>& log_;
  int shot_ = -1;
  bool connected_ = true;
  double fired_s_ = 0;
  cv::Mat last_;
};

/// A positioner that takes a second for a move.
class ScriptedPositioner final : public PositionerDevice {
 public:
  ScriptedPositioner(FakeClock& clock, std::vector<std::string>& log) : clock_(clock), log_(log) {}

  static constexpr double kMove_s = 1;
  std::string failing_stop;                              ///< a move to it ends with an alarm
  std::function<void(const std::string& stop)> on_move;  ///< called at the begin of a move; may be empty
  bool moving = false;                                   ///< set by a move, until it has ended or was halted
  int num_halts = 0;
  std::vector<RecordedStop> told;     ///< what NextStop gives, each after a second, and then that there is none
  std::vector<std::string> finished;  ///< "00 good", "01 MESSAGE"

  Result<void> Home(const std::stop_token& stop) override;
  Result<RecordedStop> MoveTo(const StopTarget& target, const std::stop_token& stop) override;
  Result<std::optional<RecordedStop>> NextStop(const std::stop_token& stop) override;
  Result<void> FinishStop(const Result<void>& taken) override;
  void Halt() noexcept override;

 private:
  FakeClock& clock_;
  std::vector<std::string>& log_;
  std::string stop_;
  std::size_t next_told_ = 0;
};

}  // namespace rigcal
