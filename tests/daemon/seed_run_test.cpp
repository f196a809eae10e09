#include "daemon/seed_run.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "config/recording_file.h"
#include "config/recording_writer.h"
#include "tests/config/temporary_folder.h"
#include "tests/seed/printed_board.h"
#include "tests/seed/seed_honesty.h"
#include "tests/seed/synthetic_studio.h"

namespace rigcal {
namespace {

using namespace synthetic;

std::string Png(const cv::Mat1f& picture) {
  cv::Mat sixteen_bits;
  picture.convertTo(sixteen_bits, CV_16U, 65535);
  std::vector<unsigned char> bytes;
  cv::imencode(".png", sixteen_bits, bytes);
  return {bytes.begin(), bytes.end()};
}

/// The studio's pictures as a recording; its board is printed flat.
void Record(const Studio& studio, const std::filesystem::path& folder) {
  auto writer = RecordingWriter::Create(folder, "studio", true);
  ASSERT_TRUE(writer) << writer.error().message;
  for (const Camera& camera : studio.truth.cameras) {
    ASSERT_TRUE(writer->AddCamera({.id = camera.id, .width_px = camera.width_px, .height_px = camera.height_px}));
  }
  for (const StopPosition& stop : studio.scene.stops) {
    ASSERT_TRUE(writer->AddStop({.id = stop.id, .axes = {{kTableAxis, AxisUnit::kRadian, stop.axes[0], {}}}}));
  }
  const BoardPrint print = PrintOf(studio.scene.board);
  for (std::size_t v = 0; v < studio.scene.views.size(); ++v) {
    const SeedView& view = studio.scene.views[v];
    const BoardPictureOptions options{.noise = 0.004, .random_seed = v};
    const cv::Mat1f picture = RenderBoard(print, studio.truth.cameras[view.camera], studio.cam_from_board[v], options);
    const auto added = writer->AddView(
        {.file = view.name + ".png", .camera = view.camera, .stop = view.stop, .subject = Subject::kChart},
        Png(picture));
    ASSERT_TRUE(added) << added.error().message;
  }
  ASSERT_TRUE(writer->Close());
}

TEST(SeedRig, FindsCamerasAxisAndStepErrorsInPictures) {
  const Studio studio =
      TurntableStudio(1, {.large_board = true, .num_cameras = 2, .num_stops = 7, .hand_held_per_camera = 4});
  const TemporaryFolder folder;
  const std::filesystem::path recording = folder.Path() / "recording";
  Record(studio, recording);
  const auto rig = ParseRig(
      "[positioner]\nkind = \"turntable\"\nstep_sigma_deg = 0.03\nwobble_sigma_deg = 0.02\nrun_out_sigma_m = 1e-5\n",
      "rig.toml");
  ASSERT_TRUE(rig) << rig.error().message;
  RunContext context({}, 2, [] { return 0.0; }, {});
  const auto seeded = SeedRig({recording, *LoadRecording(recording), studio.scene.board, *rig}, context);
  ASSERT_TRUE(seeded) << seeded.error().message;
  const SeedResult& seed = seeded->seed;
  EXPECT_LT(seed.report.rms_px, 0.15);  // issue 3
  EXPECT_TRUE(seed.report.contradictions.empty()) << seed.report.contradictions.front();
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_NEAR(seed.calibration.cameras[c].fx_px / studio.truth.cameras[c].fx_px, 1, 1e-3);
  }
  EXPECT_EQ(seed.calibration.NumViews(), 14);
  EXPECT_EQ(seed.hand_held.size(), 8u);
  const AxisError off = AxisErrorOf(studio, seed);
  EXPECT_LT(off.direction_rad, 4 * seed.rig->axis->direction_sigma_rad);
  EXPECT_LT(off.point_m, 4 * seed.rig->axis->point_sigma_m);
  // Steps are relative to each other: their mean is the zero of the table's angle.
  double mean_rad = 0;
  for (int s = 0; s < 7; ++s) mean_rad += (seed.rig->stop_errors[s][kStep] - studio.truth.stop_errors[s][kStep]) / 7;
  for (int s = 0; s < 7; ++s) {
    const double step_rad = seed.rig->stop_errors[s][kStep] - studio.truth.stop_errors[s][kStep] - mean_rad;
    EXPECT_LT(std::abs(step_rad), 0.01 * kDegree) << "stop " << s;
  }
}

}  // namespace
}  // namespace rigcal
