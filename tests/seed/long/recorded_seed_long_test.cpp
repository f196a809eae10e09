#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "core/seed/detect_chart.h"
#include "core/seed/seed_cameras.h"
#include "tests/support/middlebury_set.h"

namespace rigcal {
namespace {

/// Issue 3: 30 photographs of a Kalibr grid; OpenCV's calibration of another detector's corners has an RMS of 0.294 px.
TEST(RecordedSeed, KalibrGridOfYac) {
  const auto sets = RecordedSets();
  if (!sets || !std::filesystem::exists(*sets / "yac-aprilgrid")) GTEST_SKIP() << "RIGCAL_DATA has no yac-aprilgrid";
  std::vector<std::filesystem::path> pictures;
  for (const auto& entry : std::filesystem::directory_iterator(*sets / "yac-aprilgrid/mocap_data/cam0/data")) {
    pictures.push_back(entry);
  }
  std::sort(pictures.begin(), pictures.end());
  SeedScene scene;
  scene.board = {.border_bits = 2, .columns = 6, .rows = 6, .tag_m = 0.088, .gap_m = 0.0264};
  scene.cameras = {{"cam0", 640, 480}};
  for (const auto& path : pictures) {
    cv::Mat1f picture;
    cv::imread(path.string(), cv::IMREAD_GRAYSCALE).convertTo(picture, CV_32F, 1.0 / 255);
    const Result<ChartDetection> seen = DetectChart(picture, scene.board);
    ASSERT_TRUE(seen) << seen.error().message;
    scene.sightings.push_back({static_cast<int>(scene.views.size()), seen->corners});
    scene.views.push_back({path.stem().string(), 0, std::nullopt});
  }
  const Result<SeedResult> result = SeedCameras(scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  const SeedCameraReport& camera = result->report.cameras[0];
  const Camera& lens = result->calibration.cameras[0];
  RecordProperty("rms_px", std::to_string(camera.rms_px));
  RecordProperty("noise_scale", std::to_string(camera.noise_scale));
  RecordProperty("outliers", camera.num_outliers);
  RecordProperty("corners", camera.num_corners);
  RecordProperty("uses_k3", camera.uses_k3 ? "yes" : "no");
  RecordProperty("fx_px", std::to_string(lens.fx_px));
  RecordProperty("fy_px", std::to_string(lens.fy_px));
  RecordProperty("cx_px", std::to_string(lens.cx_px));
  RecordProperty("cy_px", std::to_string(lens.cy_px));
  EXPECT_LT(camera.rms_px, 0.30);
}

}  // namespace
}  // namespace rigcal
