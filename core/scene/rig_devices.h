#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/recording.h"

namespace rigcal {

/// A part of a picture, in pixels of the sensor; (left, top) is its first pixel.
struct SensorRegion {
  int left_px = 0, top_px = 0, width_px = 0, height_px = 0;
};

enum class CameraTrigger { kSoftware, kHardware };

/// How one physical camera is found and set. What is absent stays as the device has it.
struct CameraSettings {
  std::string id;                      ///< its name in recordings and calibrations
  std::string driver;                  ///< "genicam", "replay", "sim"
  std::string serial;                  ///< empty: found by address
  std::string address;                 ///< an IP address; empty: found by serial
  std::string pixel_format = "Mono8";  ///< GenICam's names: Mono8, Mono12, BayerRG8, ...
  CameraTrigger trigger = CameraTrigger::kSoftware;
  std::optional<double> exposure_us, gain_db;
  std::optional<int> packet_bytes;  ///< GigE Vision; absent: negotiated
  std::optional<SensorRegion> region;
  std::string lens;               ///< for the recording
  std::optional<double> focus_m;  ///< for the recording
};

/// One axis of a turntable or gantry: radians or metres, as its unit says.
struct AxisSettings {
  std::string name;           ///< its name in recordings
  std::string device_letter;  ///< what the controller calls it: "C", "X"
  AxisUnit unit = AxisUnit::kRadian;
  std::optional<double> least, most;  ///< soft limits; absent: none of rigcal's own
  double speed = 0;                   ///< rad/s or m/s; 0: the driver's own
  /// A target is always approached while the axis grows (+1) or shrinks (-1), overshooting by backlash first; 0: as it
  /// comes.
  int approach = 0;
  double backlash = 0;
};

/// The moving part of the studio as a device.
struct PositionerSettings {
  std::string driver;   ///< "linuxcnc", "grbl", "arm", "replay", "sim"; empty: none, stops are made by hand
  std::string address;  ///< HOST:PORT, a serial device, or a file
  std::vector<AxisSettings> axes;
  double settle_s = 0.5;        ///< wait after a move has ended, before a picture is taken
  double move_timeout_s = 120;  ///< beyond, a move counts as failed
  double position_tolerance_rad = 0.0017, position_tolerance_m = 0.0001;  ///< reported against commanded
};

/// How pictures are taken, checked and taken again.
struct CaptureSettings {
  double picture_s = 4;  ///< a picture that has not come within it is missing; with recover_s below the 15 s in which a
                         ///< lost camera is reported
  double recover_s = 8;  ///< how long a failed camera is given to come back
  int retakes = 2;       ///< of one picture, after the first
  double max_saturated = 0.5;              ///< share of saturated pixels
  double min_brightness = 0.01;            ///< mean of the brightest hundredth of the pixels, share of full scale
  double min_sharpness = 0.3;              ///< against the same camera's last good picture; lower is blurred
  bool refuse_identical = true;            ///< the same picture twice in a row is that of a camera that hangs
  std::vector<std::vector<double>> stops;  ///< one value per axis, radians or metres
};

/// When old recordings go. An absent part does not ask for anything to go; what a revision needs never goes.
struct KeepRule {
  std::optional<double> max_age_days;
  std::optional<int> max_count;
  std::optional<double> min_free_bytes;
};

/// Motion at the object beyond which a camera drifts: half of the smallest one that must be found (0.3 px, issue 5), as
/// far from a false alarm as from a miss.
inline constexpr double kDriftLimitPx = 0.15;

/// When a calibration in force no longer holds.
struct DriftSettings {
  double limit_px = kDriftLimitPx;
};

/// The simulated studio that stands behind devices of the driver "sim". Its motion is that of the rig's positioner.
struct SimSettings {
  std::string scene = "textured";      ///< what stands on the table when it is not the chart
  std::string surroundings = "black";  ///< "black": a dark cloth; "backdrop": textured walls and table top
  int num_cameras = 1;                 ///< those of the driver "sim", in their order in the rig file
  int width_px = 1280, height_px = 960;
  double step_error_rad = 0, wobble_rad = 0, run_out_m = 0;  ///< standard deviations of a turntable's stops
  double blur_sigma_px = 0.5;                                ///< Gaussian point spread of the lens
  double noise_sigma = 1;                                    ///< in grey levels of 8 bit
  std::uint64_t random_seed = 1;
};

/// The recording that stands behind devices of the driver "replay".
struct ReplaySettings {
  std::string recording;  ///< its folder
  bool at_recorded_speed = false;
};

}  // namespace rigcal
