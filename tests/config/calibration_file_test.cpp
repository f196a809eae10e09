#include "config/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/config/example_rig.h"
#include "tests/config/schema_check.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

Provenance ExampleProvenance() {
  return {.program_version = "0.1.0",
          .method = "rigcal",
          .options = {{"rounds", "4"}, {"masks", "auto"}},
          .random_seed = 9223372036854775807U,
          .inputs = {{"cams_par.txt", std::string(64, 'a')}},
          .notes = {"a \"quoted\" note"}};
}

/// A ring with distortion and a covariance that leaves skew and k3 out.
RigCalibration ExampleResult() {
  RigCalibration ring = ExampleRing(5);
  ring.cameras[0].k1 = -0.1 / 3, ring.cameras[0].p2 = 1e-5 / 7;
  const int size = CalibrationCovariance::PoseRow(1, 5);
  Random random(3);
  Eigen::MatrixXd half = Eigen::MatrixXd::Zero(size, size);
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column)
      if (row != kSkew && row != kK3) half(row, column) = random.Normal() * 1e-4;
  const Eigen::MatrixXd joint = half * half.transpose();
  ring.covariance = CalibrationCovariance{0.5 * (joint + joint.transpose())};
  return ring;
}

TEST(CalibrationFile, ReadsBackTheSameBits) {
  const RigCalibration written = ExampleResult();
  const std::string text = CalibrationText(written, ExampleProvenance());
  const auto content = ParseCalibration(text, "calibration.json");
  ASSERT_TRUE(content) << content.error().message;
  const RigCalibration& read = content->calibration;
  ASSERT_EQ(read.NumViews(), written.NumViews());
  EXPECT_EQ(read.cameras[0].Intrinsics(), written.cameras[0].Intrinsics());
  EXPECT_EQ(read.cameras[0].width_px, 64);
  for (int v = 0; v < read.NumViews(); ++v) {
    EXPECT_EQ(read.views[v].name, written.views[v].name);
    EXPECT_EQ(read.views[v].cam_from_world.translation, written.views[v].cam_from_world.translation);
    EXPECT_LT(read.views[v].cam_from_world.rotation.angularDistance(written.views[v].cam_from_world.rotation), 1e-15);
  }
  ASSERT_TRUE(read.covariance);
  EXPECT_EQ(read.covariance->joint, written.covariance->joint);
  EXPECT_EQ(content->provenance.random_seed, ExampleProvenance().random_seed);
  EXPECT_EQ(content->provenance.options, ExampleProvenance().options);
  EXPECT_EQ(content->provenance.notes, ExampleProvenance().notes);
}

TEST(CalibrationFile, WritingWhatWasReadGivesTheSameBytes) {
  const std::string text = CalibrationText(ExampleResult(), ExampleProvenance());
  const auto content = ParseCalibration(text, "calibration.json");
  ASSERT_TRUE(content) << content.error().message;
  EXPECT_EQ(CalibrationText(content->calibration, content->provenance), text);
}

TEST(CalibrationFile, FollowsItsSchema) {
  EXPECT_EQ(SchemaComplaints("calibration.schema.json", CalibrationText(ExampleResult(), ExampleProvenance())), "");
  EXPECT_EQ(SchemaComplaints("calibration.schema.json", CalibrationText(ExampleRing(3), {})), "");
}

TEST(CalibrationFile, SchemaNoticesAMissingKey) {
  std::string text = CalibrationText(ExampleRing(3), {});
  text.replace(text.find("\"unit\""), 6, "\"unity\"");
  EXPECT_NE(SchemaComplaints("calibration.schema.json", text), "");
}

TEST(CalibrationFile, SaysWhereItIsBroken) {
  const std::string good = CalibrationText(ExampleResult(), ExampleProvenance());
  const auto message = [&good](const std::string& old, const std::string& replacement) {
    std::string text = good;
    text.replace(text.find(old), old.size(), replacement);
    const auto content = ParseCalibration(text, "calibration.json");
    return content ? "read" : content.error().message;
  };
  EXPECT_THAT(message("\"width_px\": 64", "\"width_px\": 64.5"), HasSubstr("width_px is 64.5"));
  EXPECT_THAT(message("\"width_px\": 64", "\"width_px\": 1e30"), HasSubstr("width_px"));
  EXPECT_THAT(message("\"width_px\": 64", "\"width_px\": \"64\""), HasSubstr("/cameras/0/width_px"));
  EXPECT_THAT(message("\"fy_px\"", "\"fz_px\""), HasSubstr("fy_px"));
  EXPECT_THAT(message("\"camera\": \"camera\"", "\"camera\": \"other\""), HasSubstr("no camera 'other'"));
  EXPECT_THAT(message("\"unit\": \"m\"", "\"unit\": \"mm\""), HasSubstr("'mm'"));
  EXPECT_THAT(message("\"version\": 1", "\"version\": 2"), HasSubstr("version 2"));
  EXPECT_THAT(message("rigcal calibration", "other"), HasSubstr("format"));
  EXPECT_THAT(message("\"w\": ", "\"w\": 3, \"was\": "), HasSubstr("quaternion"));
  EXPECT_THAT(message("\"rows\": [0, ", "\"rows\": ["), HasSubstr("upper triangle"));
  EXPECT_THAT(message("\"rows\": [0, 1", "\"rows\": [0, 1000"), HasSubstr("covariance row"));
  EXPECT_THAT(message("]", ""), HasSubstr("calibration.json: "));
}

}  // namespace
}  // namespace rigcal
