#include "config/patches_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "tests/config/example_rig.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

std::vector<Patch> ExamplePatches() {
  Patch patch;
  patch.centre_in_world = {0.125, -0.25, 0.5};
  patch.normal_in_world = {0, 0.6, 0.8};
  patch.visible_views = {0, 2, 3};
  patch.ncc = 0.875F;
  std::vector<Patch> patches(3, patch);
  patches[1].visible_views.assign(300, 0);
  return patches;
}

const std::vector<cv::Vec3b> kColours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};

TEST(PatchesFile, ReadsBackTheSame) {
  const auto read = ParsePatches(PatchesPly(ExamplePatches(), kColours), "patches.ply");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 3U);
  EXPECT_EQ((*read)[0].centre_in_world, Eigen::Vector3f(0.125F, -0.25F, 0.5F));
  EXPECT_EQ((*read)[0].normal_in_world, Eigen::Vector3f(0, 0.6F, 0.8F));
  EXPECT_EQ((*read)[0].red, 3);  // colours come as BGR
  EXPECT_EQ((*read)[0].blue, 1);
  EXPECT_EQ((*read)[0].num_views, 3);
  EXPECT_EQ((*read)[1].num_views, 255);
  EXPECT_EQ((*read)[2].ncc, 0.875F);
}

TEST(PatchesFile, BytesAreWhereThePlyHeaderSays) {
  const std::string bytes = PatchesPly(ExamplePatches(), kColours);
  EXPECT_THAT(bytes, HasSubstr("format binary_little_endian 1.0\n"));
  EXPECT_THAT(bytes, HasSubstr("element vertex 3\n"));
  const std::size_t body = bytes.find("end_header\n") + 11;
  ASSERT_EQ(bytes.size(), body + 3 * (7 * 4 + 4));
  float y = 0;
  std::memcpy(&y, bytes.data() + body + 4, 4);
  EXPECT_EQ(y, -0.25F);
  EXPECT_EQ(bytes[body + 24], 3);  // red
}

TEST(PatchesFile, RefusesOtherFiles) {
  const std::string bytes = PatchesPly(ExamplePatches(), kColours);
  EXPECT_FALSE(ParsePatches("", "patches.ply"));
  EXPECT_FALSE(ParsePatches("ply\n", "patches.ply"));
  const auto cut = ParsePatches(std::string_view(bytes).substr(0, bytes.size() - 1), "patches.ply");
  ASSERT_FALSE(cut);
  EXPECT_THAT(cut.error().message, HasSubstr("patches.ply: 95 bytes"));
}

TEST(PatchesFile, ColourComesFromTheReferenceView) {
  const RigCalibration ring = ExampleRing(4);
  Patch patch;
  patch.centre_in_world = {0, 0, 0};  // projects to the principal point (31.83, 23.36)
  patch.reference_view = 2;
  ImageSet images;
  images.views.resize(4);
  for (ViewImages& view : images.views) view.gray = {cv::Mat1f(48, 64, 0.0F)};
  images.views[2].gray[0](23, 32) = 0.2F;
  EXPECT_EQ(PatchColours({patch}, images, ring)[0], cv::Vec3b(51, 51, 51));
  images.views[2].colour = cv::Mat3b(12, 16, cv::Vec3b(0, 0, 0));
  images.views[2].colour_level = 2;
  images.views[2].colour(6, 8) = {10, 20, 30};
  EXPECT_EQ(PatchColours({patch}, images, ring)[0], cv::Vec3b(10, 20, 30));
}

}  // namespace
}  // namespace rigcal
