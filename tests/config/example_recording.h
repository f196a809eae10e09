#pragma once

#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/scene/recording.h"

namespace rigcal {

/// An encoded grey picture.
inline std::string PngBytes(int width_px, int height_px, int gray) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", cv::Mat(height_px, width_px, CV_8UC1, cv::Scalar(gray)), bytes);
  return {bytes.begin(), bytes.end()};
}

/// Two cameras, a table's stop, an arm's stop, a picture held by hand: every field that there is.
inline Recording ExampleRecording() {
  Recording recording{.id = "night 7", .closed = true, .linear = true};
  recording.cameras = {{.id = "left",
                        .width_px = 8,
                        .height_px = 6,
                        .serial = "S1",
                        .model = "M",
                        .lens = "25 mm",
                        .pixel_format = "Mono8",
                        .focus_m = 0.75,
                        .temperature_celsius = 31.5},
                       {.id = "right", .width_px = 10, .height_px = 4}};
  const Rigid3d pose{ExpRotation({0.1, -0.2, 0.3}), Eigen::Vector3d(0.1, 1.0 / 3, -2)};
  recording.stops = {{.id = "00",
                      .axes = {{.axis = "table", .unit = AxisUnit::kRadian, .commanded = 0.1, .reported = 0.1001},
                               {.axis = "z", .unit = AxisUnit::kMetre, .commanded = 0.25}}},
                     {.id = "01", .axes = {}, .base_from_flange_commanded = pose, .base_from_flange_reported = pose}};
  const std::string sha256(64, 'a');
  recording.views = {
      {.file = "left/00.png",
       .camera = 0,
       .stop = 0,
       .subject = Subject::kBoth,
       .sha256 = sha256,
       .exposure_us = 8000,
       .gain_db = 0,
       .taken_at = "2025-01-31T23:59:59.25Z"},
      {.file = "right.png", .camera = 1, .stop = 1, .subject = Subject::kObject, .sha256 = sha256},
      {.file = "hand.png", .camera = 1, .stop = std::nullopt, .subject = Subject::kChart, .sha256 = sha256}};
  return recording;
}

}  // namespace rigcal
