#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "sim_fixtures/u3v/little_endian.h"
#include "sim_fixtures/u3v/usb_function.h"

namespace rigcal::sim {

struct U3vCameraSpec {
  std::string vendor = "rigcal", model = "Emulated", serial = "U3V1";
  int width_px = 640, height_px = 480;  ///< of the sensor; multiples of 8
  double temperature_celsius = 41.5;
};

/// One exposure, as the camera was set when it was triggered.
struct U3vShot {
  std::uint64_t number = 0;  ///< 0 and on, from each start of the stream
  int width_px = 0, height_px = 0, bytes_per_pixel = 1;
  double exposure_us = 0, gain_db = 0;
};

/// What the camera sees: CV_8U or CV_16U as the shot's bytes per pixel ask, of its size.
using U3vPictureSource = std::function<cv::Mat(const U3vShot& shot)>;

/// What can be wrong with it, switched while it runs.
struct U3vFaults {
  bool silent = false;                            ///< takes triggers, sends no pictures
  bool truncated = false;                         ///< leaves out the last bytes of each picture
  bool held = false;                              ///< another program has it
  std::optional<std::size_t> stalls_after_bytes;  ///< of a picture, goes no further with it (AwaitStalled)
};

/// A simulated USB3 Vision camera: GenCP registers, and pictures as leader, payload and trailer, each after a software
/// trigger. It has no free run. Safe to use from several threads.
class U3vCamera final : public UsbFunction {
 public:
  U3vCamera(const U3vCameraSpec& spec, U3vPictureSource source);

  [[nodiscard]] const U3vCameraSpec& Spec() const { return spec_; }
  [[nodiscard]] U3vFaults Faults() const;
  void Set(const U3vFaults& faults);
  /// Waits until it has stalled in the middle of a picture; false when that has not happened within timeout_s.
  bool AwaitStalled(double timeout_s);
  /// Waits until it was triggered so often since it was made; false when that has not happened within timeout_s.
  bool AwaitShots(std::uint64_t count, double timeout_s);

  void PowerOn() override;
  [[nodiscard]] bool MayBeClaimed() const override;
  void Take(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;
  std::optional<std::size_t> Give(std::uint8_t endpoint, std::span<std::uint8_t> room) override;

 private:
  enum class Phase { kLeader, kPayload, kTrailer };

  template <typename Number>
  [[nodiscard]] Number Get(std::size_t address) const {
    return GetLittle<Number>(memory_, address);
  }
  template <typename Number>
  void Put(std::size_t address, Number number) {
    SetLittle<Number>(memory_, address, number);
  }
  void PutText(std::size_t address, const std::string& text);
  /// One GenCP command; its answer.
  Bytes Answer(std::span<const std::uint8_t> command);
  void Written(std::size_t address);
  void SetPayload();
  void Shoot();
  [[nodiscard]] bool Streaming() const;
  [[nodiscard]] Bytes Leader() const;
  [[nodiscard]] Bytes Trailer() const;
  std::size_t GivePayload(std::span<std::uint8_t> room);

  U3vCameraSpec spec_;
  U3vPictureSource source_;
  mutable std::mutex mutex_;  ///< guards what follows
  U3vFaults faults_;
  std::condition_variable changed_;
  bool stalled_ = false;
  Bytes memory_;
  std::deque<Bytes> answers_;
  bool acquiring_ = false;
  std::uint64_t num_shots_ = 0, next_number_ = 0;
  std::deque<U3vShot> shots_;  ///< not yet sent; the first may be under way
  Phase phase_ = Phase::kLeader;
  cv::Mat pixels_;  ///< of the first shot, from its payload on
  std::size_t sent_bytes_ = 0;
};

}  // namespace rigcal::sim
