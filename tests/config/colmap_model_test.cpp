#include "config/colmap_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

constexpr const char* kImages =
    "# comment\n"
    "1 1 0 0 0 0.1 0.2 0.3 7 cam a/first image.png\n"
    "10.5 20.5 -1 11 21 3\n"
    "2 0.7071067811865476 0 0 0.7071067811865476 0 0 1 7 b.png\n"
    "\n";

TEST(ColmapModel, CornerOriginBecomesCentreOrigin) {
  const auto records = ParseColmapModel("7 PINHOLE 640 480 1500 1510 320 240\n", kImages, "model");
  ASSERT_TRUE(records) << Message(records);
  ASSERT_EQ(records->size(), 2U);
  EXPECT_EQ((*records)[0].camera.cx_px, 319.5);
  EXPECT_EQ((*records)[0].camera.cy_px, 239.5);
  EXPECT_EQ((*records)[0].camera.width_px, 640);
  EXPECT_EQ((*records)[0].camera.physical_id, "7");
  EXPECT_EQ((*records)[0].name, "cam a/first image.png");
  // A quarter turn about z takes x to y.
  const Eigen::Vector3d x_in_cam = (*records)[1].cam_from_world * Eigen::Vector3d::UnitX();
  EXPECT_LT((x_in_cam - Eigen::Vector3d(0, 1, 1)).norm(), 1e-12);
}

TEST(ColmapModel, ReadsEveryBrownModel) {
  const auto camera = [](const std::string& line) {
    const auto records = ParseColmapModel("7 " + line + "\n", kImages, "model");
    EXPECT_TRUE(records) << Message(records);
    return records ? (*records)[0].camera.Intrinsics() : IntrinsicVector::Zero().eval();
  };
  IntrinsicVector expected = IntrinsicVector::Zero();
  expected.head<4>() << 900, 900, 319.5, 239.5;
  EXPECT_EQ(camera("SIMPLE_PINHOLE 640 480 900 320 240"), expected);
  expected[kK1] = 0.1;
  EXPECT_EQ(camera("SIMPLE_RADIAL 640 480 900 320 240 0.1"), expected);
  expected[kK2] = 0.2;
  EXPECT_EQ(camera("RADIAL 640 480 900 320 240 0.1 0.2"), expected);
  expected[kFy] = 901, expected[kP1] = 0.3, expected[kP2] = 0.4;
  EXPECT_EQ(camera("OPENCV 640 480 900 901 320 240 0.1 0.2 0.3 0.4"), expected);
  expected[kK3] = 0.5;
  EXPECT_EQ(camera("FULL_OPENCV 640 480 900 901 320 240 0.1 0.2 0.3 0.4 0.5 0 0 0"), expected);
}

TEST(ColmapModel, RefusesWhatItCannotHold) {
  const auto message = [](const std::string& camera, const std::string& images = kImages) {
    return Message(ParseColmapModel(camera + "\n", images, "model"));
  };
  EXPECT_THAT(message("7 OPENCV_FISHEYE 640 480 1 1 1 1 0 0 0 0"), HasSubstr("OPENCV_FISHEYE"));
  EXPECT_THAT(message("7 FULL_OPENCV 640 480 1 1 1 1 0 0 0 0 0 0 0.01 0"), HasSubstr("k4, k5 and k6"));
  EXPECT_THAT(message("7 PINHOLE 640 480 1500 1510 320"), HasSubstr("3 parameters"));
  EXPECT_THAT(message("7 PINHOLE 0 480 1500 1510 320 240"), HasSubstr("0 x 480"));
  EXPECT_THAT(message("8 PINHOLE 640 480 1500 1510 320 240"), HasSubstr("camera 7 is not in cameras.txt"));
  const std::string pinhole = "7 PINHOLE 640 480 1500 1510 320 240";
  EXPECT_THAT(message(pinhole + "\n" + pinhole), HasSubstr("twice"));
  EXPECT_THAT(message(pinhole, "1 2 0 0 0 0 0 0 7 a.png\n\n"), HasSubstr("quaternion"));
  EXPECT_THAT(message(pinhole, "1 1 0 0 0 0 0 7 a.png\n\n"), HasSubstr("images.txt line 1"));
  EXPECT_THAT(message(pinhole, "1 1 0 0 0 0 0 0 7 a.png\n2 1 0 0 0 0 0 0 7 b.png\n"), HasSubstr("line 2"));
}

TEST(ColmapModel, FolderIsRecognised) {
  const TemporaryFolder folder;
  folder.Write("cameras.txt", "7 PINHOLE 640 480 1500 1510 320 240\n");
  folder.Write("images.txt", kImages);
  const auto loaded = LoadCameras(folder.Path(), {.min_views = 2});
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_TRUE(loaded->sizes_known);
  EXPECT_EQ(loaded->files.size(), 2U);
  const TemporaryFolder binary;
  binary.Write("cameras.bin", "");
  const auto refused = LoadCameras(binary.Path(), {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("binary COLMAP model"));
}

}  // namespace
}  // namespace rigcal
