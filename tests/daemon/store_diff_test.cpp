#include "daemon/store_diff.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "config/store/sqlite_store.h"
#include "tests/config/example_revision.h"
#include "tests/config/example_rigged.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Two revisions of the example's two cameras; in the second one the right camera has turned.
class StoreDiff : public ::testing::Test {
 protected:
  void SetUp() override {
    store_ = std::move(*OpenSqliteStore(folder_.Path() / kStoreFile, {.create = true}));
    RigCalibration rigged = ExampleRigged();
    Append(rigged);
    Eigen::Matrix<double, 6, 1> turn = Eigen::Matrix<double, 6, 1>::Zero();
    turn[1] = 0.05;  // about +y: 1.7 px to the right at 33 px of focal length
    auto& mount = rigged.rig->model.cam_from_mount[1];
    mount = Disturbed(*mount, turn);
    Append(rigged);
  }
  void Append(const RigCalibration& calibration) {
    CalibrationRevision revision = ExampleRevision("studio", 1);
    revision.calibration_text = CalibrationText(calibration, revision.head.origin.run);
    ASSERT_TRUE(store_->Append(revision));
  }
  TemporaryFolder folder_;
  std::unique_ptr<CalibrationStore> store_;
};

TEST_F(StoreDiff, TellsCameraWayAndSigma) {
  const auto diff = DiffRevisions(*store_, "studio", 1, 2);
  ASSERT_TRUE(diff) << diff.error().message;
  const std::string text = DiffText(*diff);
  EXPECT_THAT(text, AllOf(HasSubstr("revision 1 ("), HasSubstr("to 2 ("), HasSubstr("at the rig's exact stops"),
                          HasSubstr("  left "), HasSubstr("  right "), HasSubstr("more than its sigma ("),
                          HasSubstr("fewer than three cameras")));
  const auto json = nlohmann::json::parse(DiffJson(*diff));
  EXPECT_EQ(json["before"], 1);
  EXPECT_EQ(json["after"], 2);
  ASSERT_EQ(json["cameras"].size(), 2U);
  EXPECT_EQ(json["cameras"][1]["camera"], "right");
  EXPECT_EQ(json["cameras"][1]["more_than_sigma"], true);
  EXPECT_GT(json["cameras"][1]["sigma_px"], 0);
  EXPECT_GT(json["mean_px"], 0);
}

TEST_F(StoreDiff, TheSameIsWithinItsSigma) {
  const auto diff = DiffRevisions(*store_, "studio", 2, 2);
  ASSERT_TRUE(diff) << diff.error().message;
  EXPECT_THAT(DiffText(*diff), AllOf(HasSubstr("0.00 px at the object"), HasSubstr("within its sigma (0.0 times)")));
}

TEST_F(StoreDiff, MissingRevisionIsNamed) {
  for (const auto& [before, after] : {std::pair(1, 9), std::pair(9, 1)}) {
    const auto diff = DiffRevisions(*store_, "studio", before, after);
    ASSERT_FALSE(diff);
    EXPECT_EQ(diff.error().code, ErrorCode::kNotFound);
    EXPECT_THAT(diff.error().message, HasSubstr("has no revision 9"));
  }
}

}  // namespace
}  // namespace rigcal
