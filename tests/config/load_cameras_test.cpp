#include "config/load_cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/calibration_file.h"
#include "config/middlebury.h"
#include "core/base/random.h"
#include "tests/config/example_rigged.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kIdentityPose = "1 0 0 0 1 0 0 0 1 0.1 0.2 0.3";

std::string ParLine(const std::string& name, const std::string& k = "1500 0 320 0 1510 240 0 0 1",
                    const std::string& pose = kIdentityPose) {
  return name + " " + k + " " + pose + "\n";
}

std::string ThreeLines() {
  return "3\n" + ParLine("a.png") + ParLine("b.png") + ParLine("c.png");
}

Result<LoadedCameras> LoadText(const std::string& text, const CameraFileOptions& options = {}) {
  const TemporaryFolder folder;
  return LoadCameras(folder.Write("cams_par.txt", text), options);
}

TEST(LoadMiddlebury, ReadsCamerasAndPoses) {
  const std::string k = "1520.4 0 302.32 0 1525.9 246.87 0 0 1", quarter_turn = "0 -1 0 1 0 0 0 0 1 -0.07 0.02 0.61";
  const auto loaded =
      LoadText("3\n" + ParLine("a.png", k, quarter_turn) + "\r\n" + ParLine("b.png", k) + ParLine("c.png", k));
  ASSERT_TRUE(loaded) << Message(loaded);
  const RigCalibration& calibration = loaded->calibration;
  ASSERT_EQ(calibration.NumViews(), 3);
  ASSERT_EQ(calibration.NumCameras(), 1);
  const Camera& camera = calibration.CameraOf(0);
  EXPECT_EQ(camera.fx_px, 1520.4);
  EXPECT_EQ(camera.fy_px, 1525.9);
  EXPECT_EQ(camera.cx_px, 302.32);  // the centre of the first pixel is (0, 0) on both sides: no half pixel
  EXPECT_EQ(camera.cy_px, 246.87);
  EXPECT_FALSE(loaded->sizes_known);
  EXPECT_EQ(calibration.unit, LengthUnit::kUnknown);
  EXPECT_EQ(calibration.views[0].name, "a.png");
  const Eigen::Vector3d x_in_cam = calibration.views[0].cam_from_world * Eigen::Vector3d(1, 2, 3);
  EXPECT_LT((x_in_cam - Eigen::Vector3d(-2 - 0.07, 1 + 0.02, 3 + 0.61)).norm(), 1e-12);
  EXPECT_THAT(loaded->notes, IsEmpty());
  EXPECT_EQ(loaded->max_intrinsics_spread_px, 0);
  ASSERT_EQ(loaded->files.size(), 1U);
  EXPECT_EQ(loaded->files[0].name, "cams_par.txt");
}

TEST(LoadMiddlebury, SharedCameraStartsFromTheMedianAndSaysSo) {
  const std::string text = "3\n" + ParLine("a.png", "1500 0 320 0 1510 240 0 0 1") +
                           ParLine("b.png", "1502 0 321 0 1512 243 0 0 1") +
                           ParLine("c.png", "1600 0 322 0 1530 241 0 0 1");
  const auto loaded = LoadText(text);
  ASSERT_TRUE(loaded) << Message(loaded);
  ASSERT_EQ(loaded->calibration.NumCameras(), 1);
  EXPECT_EQ(loaded->calibration.cameras[0].fx_px, 1502);
  EXPECT_EQ(loaded->calibration.cameras[0].cy_px, 241);
  EXPECT_EQ(loaded->max_intrinsics_spread_px, 98);
  EXPECT_THAT(loaded->notes, ElementsAre(HasSubstr("98 px")));
}

TEST(LoadMiddlebury, PerViewKeepsIntrinsicsApart) {
  const std::string text = "3\n" + ParLine("a.png", "1500 0 320 0 1510 240 0 0 1") +
                           ParLine("b.png", "1502 0 321 0 1512 243 0 0 1") + ParLine("c.png");
  const auto loaded = LoadText(text, {.intrinsics = IntrinsicsMode::kPerView});
  ASSERT_TRUE(loaded) << Message(loaded);
  ASSERT_EQ(loaded->calibration.NumCameras(), 3);
  EXPECT_EQ(loaded->calibration.cameras[1].id, "camera/b.png");
  EXPECT_EQ(loaded->calibration.cameras[1].physical_id, "camera");
  EXPECT_EQ(loaded->calibration.CameraOf(1).fx_px, 1502);
  EXPECT_THAT(loaded->notes, IsEmpty());
}

TEST(LoadMiddlebury, UnchangedSharesCamerasOnlyWhereTheyAreTheSame) {
  const TemporaryFolder folder;
  const auto same = LoadCamerasUnchanged(folder.Write("same_par.txt", ThreeLines()));
  ASSERT_TRUE(same) << Message(same);
  EXPECT_EQ(same->calibration.NumCameras(), 1);
  const std::string differing = "2\n" + ParLine("a.png") + ParLine("b.png", "1500 3 320 0 1510 240.5 0 0 1");
  const auto kept = LoadCamerasUnchanged(folder.Write("differing_par.txt", differing));
  ASSERT_TRUE(kept) << Message(kept);
  ASSERT_EQ(kept->calibration.NumCameras(), 2);
  EXPECT_EQ(kept->calibration.CameraOf(1).cy_px, 240.5);
  EXPECT_EQ(kept->calibration.CameraOf(1).skew_px, 3);
}

TEST(LoadCalibration, UnchangedTakesItAsItStands) {
  const TemporaryFolder folder;
  RigCalibration rigged = ExampleRigged();
  rigged.views.pop_back();  // "right" has a place in the rig and no view
  const std::string text = CalibrationText(rigged, {});
  const auto path = folder.Write("calibration.json", text);
  const auto loaded = LoadCamerasUnchanged(path);
  ASSERT_TRUE(loaded) << Message(loaded);
  EXPECT_EQ(CalibrationText(loaded->calibration, {}), CalibrationText(ParseCalibration(text, "")->calibration, {}));
  EXPECT_EQ(loaded->calibration.NumCameras(), 2);
  EXPECT_TRUE(loaded->calibration.rig);
  const auto regrouped = LoadCamerasUnchanged(path, {.camera_from_name = "(ring)"});
  ASSERT_TRUE(regrouped) << Message(regrouped);
  EXPECT_FALSE(regrouped->calibration.rig);  // its cameras are others
}

TEST(LoadMiddlebury, ARecordingTellsPhysicalCameras) {
  const std::string text = "3\n" + ParLine("a.png") + ParLine("b.png") + ParLine("c.png");
  const auto loaded = LoadText(text, {.camera_by_image = {{"a.png", "up"}, {"b.png", "low"}, {"c.png", "up"}}});
  ASSERT_TRUE(loaded) << Message(loaded);
  ASSERT_EQ(loaded->calibration.NumCameras(), 2);
  EXPECT_EQ(loaded->calibration.CameraOf(1).id, "low");
  EXPECT_EQ(loaded->calibration.views[2].camera, 0);
  EXPECT_THAT(Message(LoadText(text, {.camera_by_image = {{"a.png", "up"}}})), HasSubstr("no picture 'b.png'"));
}

TEST(LoadMiddlebury, RegexTellsPhysicalCameras) {
  const std::string text =
      "4\n" + ParLine("left_0.png") + ParLine("right_0.png") + ParLine("left_1.png") + ParLine("right_1.png");
  const auto loaded = LoadText(text, {.camera_from_name = "^([a-z]+)_"});
  ASSERT_TRUE(loaded) << Message(loaded);
  ASSERT_EQ(loaded->calibration.NumCameras(), 2);
  EXPECT_EQ(loaded->calibration.cameras[1].id, "right");
  EXPECT_EQ(loaded->calibration.views[2].camera, 0);
  EXPECT_EQ(loaded->calibration.views[3].camera, 1);
  EXPECT_THAT(Message(LoadText(text, {.camera_from_name = "^(up)_"})), HasSubstr("'left_0.png'"));
  EXPECT_THAT(Message(LoadText(text, {.camera_from_name = "left"})), HasSubstr("no group"));
  EXPECT_THAT(Message(LoadText(text, {.camera_from_name = "(["})), HasSubstr("not a regular expression"));
}

TEST(LoadMiddlebury, SkewIsRefusedIgnoredOrKept) {
  const auto with_skew = [](const std::string& skew) {
    const std::string k = "1500 " + skew + " 320 0 1510 240 0 0 1";
    return "3\n" + ParLine("a.png", k) + ParLine("b.png", k) + ParLine("c.png", k);
  };
  EXPECT_THAT(Message(LoadText(with_skew("-0.011"))), AllOf(HasSubstr("k12"), HasSubstr("-0.011"), HasSubstr("0.01")));
  const auto rounding = LoadText(with_skew("-0.0099"));
  ASSERT_TRUE(rounding) << Message(rounding);
  EXPECT_EQ(rounding->calibration.cameras[0].skew_px, 0);
  const auto kept = LoadText(with_skew("5"), {.allow_skew = true});
  ASSERT_TRUE(kept) << Message(kept);
  EXPECT_EQ(kept->calibration.cameras[0].skew_px, 5);
}

TEST(LoadMiddlebury, NearlyARotationIsMadeOne) {
  const auto loaded = LoadText("3\n" + ParLine("a.png", "1500 0 320 0 1510 240 0 0 1", "1.0004 0 0 0 1 0 0 0 1 0 0 0") +
                               ParLine("b.png") + ParLine("c.png"));
  ASSERT_TRUE(loaded) << Message(loaded);
  EXPECT_LT(loaded->calibration.views[0].cam_from_world.rotation.angularDistance(Eigen::Quaterniond::Identity()), 1e-9);
  EXPECT_NEAR(loaded->calibration.views[0].cam_from_world.rotation.norm(), 1, 1e-15);
}

struct BadFile {
  std::string text;
  std::vector<std::string> named;  // what the message must say
};

class BadMiddlebury : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadMiddlebury, IsRefusedInOneSentence) {
  const auto loaded = LoadText(GetParam().text);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kBadInput);
  EXPECT_THAT(loaded.error().message, HasSubstr("cams_par.txt"));
  for (const std::string& name : GetParam().named) EXPECT_THAT(loaded.error().message, HasSubstr(name));
  EXPECT_EQ(loaded.error().message.find('\n'), std::string::npos);
}

const std::string kGoodK = "1500 0 320 0 1510 240 0 0 1";

INSTANTIATE_TEST_SUITE_P(
    All, BadMiddlebury,
    ::testing::Values(
        BadFile{"3\n" + ParLine("a.png") + "b.png 1500 0 320 0 1510\n" + ParLine("c.png"),
                {"line 3", "b.png", "5", "21"}},
        BadFile{"3\n" + ParLine("a.png") + ParLine("b.png", "nan 0 320 0 1510 240 0 0 1") + ParLine("c.png"),
                {"line 3", "b.png", "nan", "finite"}},
        BadFile{"3\n" + ParLine("a.png") + ParLine("b.png", "1e999 0 320 0 1510 240 0 0 1") + ParLine("c.png"),
                {"line 3", "1e999"}},
        BadFile{"3\n" + ParLine("a.png", kGoodK, "1 0 0 0 1 0 0 0 1 0 0 x0") + ParLine("b.png") + ParLine("c.png"),
                {"line 2", "x0"}},
        BadFile{"3\n" + ParLine("a.png", kGoodK, "1.002 0 0 0 1 0 0 0 1 0 0 0") + ParLine("b.png") + ParLine("c.png"),
                {"line 2", "a.png", "rotation", "0.004", "0.001"}},
        BadFile{"3\n" + ParLine("a.png", kGoodK, "1 0 0 0 1 0 0 0 -1 0 0 0") + ParLine("b.png") + ParLine("c.png"),
                {"line 2", "mirror"}},
        BadFile{"3\n" + ParLine("a.png", "-1500 0 320 0 1510 240 0 0 1") + ParLine("b.png") + ParLine("c.png"),
                {"line 2", "a.png", "-1500"}},
        BadFile{"3\n" + ParLine("a.png", "1500 0 320 0.5 1510 240 0 0 1") + ParLine("b.png") + ParLine("c.png"),
                {"line 2", "k21", "0.5"}},
        BadFile{"3\n" + ParLine("a.png", "1500 0 320 0 1510 240 0 0 2") + ParLine("b.png") + ParLine("c.png"),
                {"line 2", "k33"}},
        BadFile{"3\n" + ParLine("a.png") + ParLine("b.png") + ParLine("a.png"), {"line 4", "line 2", "a.png"}},
        BadFile{"2\n" + ParLine("a.png") + ParLine("b.png"), {"2 views", "3"}},
        BadFile{"4\n" + ParLine("a.png") + ParLine("b.png") + ParLine("c.png"), {"line 1", "4", "3"}},
        BadFile{"3.5\n" + ParLine("a.png"), {"line 1", "3.5"}}, BadFile{"", {"empty"}}, BadFile{" \n \n", {"empty"}},
        BadFile{"# cameras\n" + ParLine("a.png"), {"no camera file"}}));

TEST(LoadCameras, MissingFileIsNotFound) {
  const auto loaded = LoadCameras("/nowhere/cams_par.txt", {});
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(loaded.error().message, HasSubstr("/nowhere/cams_par.txt"));
}

/// Reads each mutation of a file: bytes changed, cut off or doubled. Whatever comes, it ends in an Error or cameras.
void ReadMutations(const std::string& text, const std::function<void(const std::string&)>& read) {
  constexpr int kMutations = 400;
  Random random(7);
  for (int i = 0; i < kMutations; ++i) {
    std::string mutated = text;
    for (std::size_t changes = 1 + random.Index(4); changes > 0; --changes)
      mutated[random.Index(mutated.size())] = static_cast<char>(random.Index(256));
    if (random.Uniform() < 0.2) mutated.resize(random.Index(mutated.size()));
    if (random.Uniform() < 0.1) mutated += mutated.substr(random.Index(mutated.size() + 1));
    read(mutated);
  }
}

TEST(LoadCameras, GarbageNeverCrashes) {
  const TemporaryFolder folder;
  const RigCalibration ring = ExampleRing(4);
  for (const std::string& text : {MiddleburyText(ring), CalibrationText(ring, {})}) {
    ReadMutations(text, [&](const std::string& mutated) {
      const auto loaded = LoadCameras(folder.Write("cams", mutated), {.camera_from_name = ".*_(.*)[.]"});
      EXPECT_TRUE(loaded || !loaded.error().message.empty());
    });
  }
}

TEST(LoadCameras, OwnFileKeepsEverything) {
  const TemporaryFolder folder;
  RigCalibration ring = ExampleRing(4);
  ring.cameras[0].k1 = -0.1;
  const int size = CalibrationCovariance::PoseRow(1, 4);
  ring.covariance = CalibrationCovariance{Eigen::MatrixXd::Identity(size, size) * 1e-6};
  const auto path = folder.Write("calibration.json", CalibrationText(ring, {}));
  const auto loaded = LoadCameras(path, {});
  ASSERT_TRUE(loaded) << Message(loaded);
  EXPECT_TRUE(loaded->sizes_known);
  EXPECT_EQ(loaded->calibration.unit, LengthUnit::kMetre);
  EXPECT_EQ(loaded->calibration.cameras[0].k1, -0.1);
  ASSERT_TRUE(loaded->calibration.covariance);
  EXPECT_EQ(loaded->calibration.covariance->joint, ring.covariance->joint);
  // Gathered in another way, the covariance no longer belongs to the parameters.
  const auto split = LoadCameras(path, {.intrinsics = IntrinsicsMode::kPerView});
  ASSERT_TRUE(split) << Message(split);
  EXPECT_FALSE(split->calibration.covariance);
  EXPECT_THAT(split->notes, ElementsAre(HasSubstr("covariance")));
}

TEST(LoadCameras, RecordedSets) {
  const char* data = std::getenv("RIGCAL_DATA");
  if (data == nullptr) GTEST_SKIP() << "RIGCAL_DATA is not set";
  for (const auto& [file, num_views] : {std::pair("templeSparseRing/templeSR_par.txt", 16),
                                        {"squirrel-turntable/squirrel_par.txt", 36},
                                        {"fountain-P11/fountain-P11_par.txt", 11}}) {
    const auto loaded = LoadCameras(std::filesystem::path(data) / file, {});
    ASSERT_TRUE(loaded) << Message(loaded);
    EXPECT_EQ(loaded->calibration.NumViews(), num_views);
    EXPECT_LT(loaded->max_intrinsics_spread_px, 1) << file;
  }
}

}  // namespace
}  // namespace rigcal
