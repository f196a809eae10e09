#include "config/rig_views.h"

#include "config/atomic_file.h"
#include "config/calibration_file.h"
#include "core/rig/rig_model_pose.h"
#include "tests/config/example_rigged.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

/// Both cameras at two stops, and a picture of the chart.
Recording ObjectRecording() {
  Recording recording{.id = "object", .closed = true};
  recording.cameras = {{.id = "right", .width_px = 64, .height_px = 48},
                       {.id = "left", .width_px = 64, .height_px = 48}};
  recording.stops = {{.id = "00", .axes = {{.axis = "table", .commanded = 0}}},
                     {.id = "01", .axes = {{.axis = "table", .commanded = 0.5, .reported = 0.6}}}};
  recording.views = {{.file = "r0.png", .camera = 0, .stop = 0},
                     {.file = "chart.png", .camera = 0, .stop = 1, .subject = Subject::kChart},
                     {.file = "l0.png", .camera = 1, .stop = 0},
                     {.file = "l1.png", .camera = 1, .stop = 1, .subject = Subject::kBoth}};
  return recording;
}

TEST(PlaceRecording, GivesEveryPictureOfTheObjectThePoseOfItsStop) {
  const RigCalibration rigged = ExampleRigged();
  const auto placed = PlaceRecording(rigged, "calibration.json", ObjectRecording(), "REC");
  ASSERT_TRUE(placed) << placed.error().message;
  ASSERT_EQ(placed->calibration.NumViews(), 3);
  EXPECT_EQ(placed->stop_of_view, (std::vector<int>{0, 0, 1}));
  const View& last = placed->calibration.views[2];
  EXPECT_EQ(last.name, "l1.png");
  EXPECT_EQ(placed->calibration.CameraOf(2).id, "left");
  const StopMotion motion = MotionAt(rigged.rig->model.positioner, {"", {0.6}, {}}, StopError::Zero());
  const Rigid3d expected = CamFromWorld(*rigged.rig->model.cam_from_mount[0], motion);
  EXPECT_LT((last.cam_from_world.translation - expected.translation).norm(), 1e-15);
  EXPECT_LT(last.cam_from_world.rotation.angularDistance(expected.rotation), 1e-15);
  EXPECT_FALSE(placed->calibration.covariance);
}

TEST(PlaceRecording, RefusesWhatTheRigDoesNotKnow) {
  const RigCalibration rigged = ExampleRigged();
  const auto refused = [](const RigCalibration& with, const Recording& recording,
                          const std::vector<std::string>& parts) {
    ExpectRefused(PlaceRecording(with, "calibration.json", recording, "REC"), parts);
  };
  Recording recording = ObjectRecording();
  recording.cameras[0].id = "third";
  refused(rigged, recording, {"calibration.json", "no camera 'third'", "REC"});
  recording = ObjectRecording();
  recording.cameras[1].width_px = 65;
  refused(rigged, recording, {"camera 'left' is 64 x 48 px", "65 x 48"});
  recording = ObjectRecording();
  recording.views[2].stop.reset();
  refused(rigged, recording, {"REC", "'l0.png' has no stop"});
  recording = ObjectRecording();
  recording.views.pop_back();
  refused(rigged, recording, {"in 2 views, at least 3"});
  recording = ObjectRecording();
  recording.stops[1].axes[0].axis = "z";
  refused(rigged, recording, {"stop '01'", "'table'"});
  RigCalibration no_lens = rigged;
  no_lens.cameras[0].fx_px = 0;
  refused(no_lens, ObjectRecording(), {"camera 'left'", "focal length 0 x"});
  RigCalibration unplaced = rigged;
  unplaced.rig->model.cam_from_mount[1].reset();
  refused(unplaced, ObjectRecording(), {"camera 'right' has no place in the rig"});
}

TEST(LoadRiggedCameras, TellsWhetherAFileHasARig) {
  const TemporaryFolder folder;
  RigCalibration rigged = ExampleRigged();
  ASSERT_TRUE(WriteCalibration(folder.Path() / "rig.json", rigged, {}));
  rigged.rig.reset();
  ASSERT_TRUE(WriteCalibration(folder.Path() / "free.json", rigged, {}));
  ASSERT_TRUE(WriteFileAtomically(folder.Path() / "cams_par.txt", "0\n"));
  const auto with = LoadRiggedCameras(folder.Path() / "rig.json");
  ASSERT_TRUE(with) << with.error().message;
  ASSERT_TRUE(with->has_value());
  EXPECT_EQ((*with)->file.name, "rig.json");
  EXPECT_EQ((*with)->calibration.NumCameras(), 2);
  for (const char* name : {"free.json", "cams_par.txt", ""}) {
    const auto without = LoadRiggedCameras(folder.Path() / name);
    ASSERT_TRUE(without) << without.error().message;
    EXPECT_FALSE(without->has_value()) << name;
  }
  EXPECT_FALSE(LoadRiggedCameras(folder.Path() / "nothing.json"));
}

}  // namespace
}  // namespace rigcal
