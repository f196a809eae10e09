#include "config/rig_section.h"

#include "config/calibration_file.h"
#include "tests/config/example_rigged.h"
#include "tests/config/refusals.h"
#include "tests/config/schema_check.h"

namespace rigcal {
namespace {

std::string ExampleText() {
  return CalibrationText(ExampleRigged(), {.program_version = "0.1.0", .method = "seed"});
}

TEST(RigSection, ReadsBackTheSameRig) {
  const RigEstimate written = *ExampleRigged().rig;
  EXPECT_EQ(SchemaComplaints("calibration.schema.json", ExampleText()), "");
  const auto content = ParseCalibration(ExampleText(), "calibration.json");
  ASSERT_TRUE(content) << content.error().message;
  ASSERT_TRUE(content->calibration.rig);
  const RigEstimate& read = *content->calibration.rig;
  EXPECT_EQ(read.model.positioner.kind, PositionerKind::kTurntable);
  EXPECT_EQ(read.axes, written.axes);
  EXPECT_EQ(read.model.error_sigma, written.model.error_sigma);
  EXPECT_EQ(read.covariance.joint, written.covariance.joint);
  for (int c = 0; c < 2; ++c) {
    const Rigid3d& back = read.model.cam_from_mount[c].value();
    EXPECT_EQ(back.translation, written.model.cam_from_mount[c]->translation);
    EXPECT_LT(back.rotation.angularDistance(written.model.cam_from_mount[c]->rotation), 1e-15);
  }
}

TEST(RigSection, KeepsAGantrysAxesAndACameraWithoutAPlace) {
  RigCalibration rigged = ExampleRigged();
  rigged.rig->model = Gantry(2, PositionerLoad::kCameras);
  rigged.rig->model.positioner.axes_in_stage.col(1) = Eigen::Vector3d(0.1, 0.2, 0.97);
  rigged.rig->model.cam_from_mount = {std::nullopt, Rigid3d{}};
  rigged.rig->axes = {"x", "z"};
  const std::string text = CalibrationText(rigged, {});
  EXPECT_EQ(SchemaComplaints("calibration.schema.json", text), "");
  const auto content = ParseCalibration(text, "calibration.json");
  ASSERT_TRUE(content) << content.error().message;
  const RigModel& read = content->calibration.rig->model;
  EXPECT_EQ(read.positioner.num_axes, 2);
  EXPECT_EQ(read.positioner.load, PositionerLoad::kCameras);
  EXPECT_EQ(read.positioner.axes_in_stage, rigged.rig->model.positioner.axes_in_stage);
  EXPECT_FALSE(read.cam_from_mount[0]);
  EXPECT_TRUE(read.cam_from_mount[1]);
}

TEST(RigSection, RefusesWhatItCannotUse) {
  const auto refused = [](const std::string& from, const std::string& to, const std::vector<std::string>& parts) {
    SCOPED_TRACE(to);
    ExpectRefused(ParseCalibration(Replaced(ExampleText(), from, to), "calibration.json"), parts);
  };
  refused("\"turntable\"", "\"carousel\"", {"calibration.json", "kind is 'carousel'", "turntable, gantry, arm"});
  refused("\"carries\": \"object\"", "\"carries\": \"nothing\"", {"carries is 'nothing'"});
  refused("\"carries\": \"object\"", "\"carries\": \"cameras\"", {"a turntable carries the object"});
  refused("\"camera\": \"right\",\n        \"cam_from_mount\"", "\"camera\": \"left\",\n        \"cam_from_mount\"",
          {"'left' is mounted twice"});
  refused("\"axes\": [\"table\"]", "\"axes\": []", {"0 axes of a turntable"});
  refused("\"stop_error_sigma\": [", "\"stop_error_sigma\": [1, ", {"stop_error_sigma has 7 numbers, 6"});
  refused("\"stop_error_sigma\": [", "\"stop_error_sigma\": [-1, 0, 0, 0, 0, 0], \"was\": [", {"negative"});
  refused("\"camera\": \"right\",\n        \"cam_from_mount\"", "\"camera\": \"middle\",\n        \"cam_from_mount\"",
          {"a camera 'middle'"});
}

TEST(RigSection, RefusesWhatIsTheCovarianceOfNothing) {
  const auto refused = [](const auto& spoil, const std::string& part) {
    RigCalibration rigged = ExampleRigged();
    spoil(rigged.rig->covariance.joint);
    ExpectRefused(ParseCalibration(CalibrationText(rigged, {}), "calibration.json"), {part});
  };
  const int mount = RigCovariance::MountRow(2, 1);
  refused([](Eigen::MatrixXd& joint) { joint(3, 3) *= -1; }, "row 3 of the covariance has the variance -");
  refused([=](Eigen::MatrixXd& joint) { joint.row(mount).setZero(), joint.col(mount).setZero(); },
          fmt::format("rows {} to {}, a pose, only 5", mount, mount + 5));
  refused(
      [=](Eigen::MatrixXd& joint) {
        joint(0, mount) = joint(mount, 0) = 2 * std::sqrt(joint(0, 0) * joint(mount, mount));
      },
      "not positive definite");
}

}  // namespace
}  // namespace rigcal
