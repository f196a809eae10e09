#pragma once

namespace rigcal {

/// A turntable with every table and nearly every key; the line numbers are those of the messages in the tests.
inline constexpr const char* kWholeRig = R"([positioner]
kind = "turntable"
driver = "linuxcnc"
address = "127.0.0.1:5007"
settle_s = 0.25
move_timeout_s = 60
tolerance_deg = 0.05
[[positioner.axis]]
letter = "C"
limits_deg = [-10, 370]
speed_deg_s = 20
approach = "up"
backlash_deg = 2
[stops]
start_deg = 10
step_deg = 90
count = 4
[[camera]]
id = "left"
driver = "genicam"
serial = "S1"
pixel_format = "BayerRG12"
trigger = "hardware"
exposure_us = 8000
gain_db = 1.5
packet_bytes = 8000
region_px = [8, 16, 640, 480]
lens = "25 mm"
focus_m = 0.75
[[camera]]
id = "right"
driver = "genicam"
address = "127.0.0.2"
[capture]
picture_s = 3
recover_s = 6
retakes = 1
max_saturated = 0.4
min_brightness = 0.02
min_sharpness = 0.2
refuse_identical = false
[keep]
max_age_days = 30
max_count = 100
min_free_gb = 20
[chart]
board = "board.toml"
[publish]
rig = "studio"
folder = "published"
formats = ["colmap", "opencv"]
undistorted = true
)";

/// A gantry in three axes, driven by GRBL, with two stops.
inline constexpr const char* kGantryRig = R"([positioner]
kind = "gantry"
carries = "cameras"
driver = "grbl"
address = "/dev/ttyUSB0"
axes = ["x", "z"]
[[positioner.axis]]
name = "z"
limits_m = [0, 0.5]
speed_m_s = 0.1
approach = "down"
backlash_m = 0.002
[stops]
positions_m = [[0, 0.1], [0.2, 0.1]]
)";

/// The simulated studio in a few lines.
inline constexpr const char* kSimRig = R"([positioner]
kind = "turntable"
driver = "sim"
[stops]
count = 12
[sim]
scene = "plaster"
num_cameras = 3
step_error_deg = 0.02
)";

}  // namespace rigcal
