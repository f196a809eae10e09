#include "config/mask_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(MaskFiles, SameStemAnyExtension) {
  const TemporaryFolder folder;
  const auto a = folder.Write("a.png", ""), b = folder.Write("b.jpg", ""), c = folder.Write("sub/c.bmp", "");
  const auto masks = FindMaskFiles({"a.jpg", "b.tif", "sub/c.png"}, folder.Path(), "");
  ASSERT_TRUE(masks) << Message(masks);
  EXPECT_THAT(*masks, ElementsAre(a, b, c));
}

TEST(MaskFiles, PatternFindsOtherNames) {
  const TemporaryFolder folder;
  const auto zero = folder.Write("contour_0.jpg", ""), seven = folder.Write("contour_7.jpg", ""),
             twenty = folder.Write("contour_20.jpg", "");
  const std::string pattern = "image_0*([0-9]+)=contour_$1";
  const auto masks = FindMaskFiles({"image_00.jpg", "image_07.jpg", "image_20.jpg"}, folder.Path(), pattern);
  ASSERT_TRUE(masks) << Message(masks);
  EXPECT_THAT(*masks, ElementsAre(zero, seven, twenty));
  EXPECT_THAT(Message(FindMaskFiles({"view_00.jpg"}, folder.Path(), pattern)),
              AllOf(HasSubstr("does not match"), HasSubstr("view_00")));
  EXPECT_THAT(Message(FindMaskFiles({"image_00.jpg"}, folder.Path(), "contour_$1")), HasSubstr("REGEX=REPLACEMENT"));
  EXPECT_THAT(Message(FindMaskFiles({"image_00.jpg"}, folder.Path(), "([=x")), HasSubstr("not a regular expression"));
}

TEST(MaskFiles, MissingAndDoubleMasksAreNamed) {
  const TemporaryFolder folder;
  folder.Write("a.png", "");
  EXPECT_THAT(Message(FindMaskFiles({"a.jpg", "b.jpg"}, folder.Path(), "")),
              AllOf(HasSubstr(folder.Path().string()), HasSubstr("'b.jpg'")));
  EXPECT_THAT(Message(FindMaskFiles({"a.jpg"}, folder.Path() / "nowhere", "")), HasSubstr("nowhere"));
  const cv::Mat mask(4, 4, CV_8UC1, cv::Scalar(255));
  cv::imwrite((folder.Path() / "c.png").string(), mask);
  folder.Write("c.txt", "a note");
  EXPECT_TRUE(FindMaskFiles({"c.jpg"}, folder.Path(), ""));
  cv::imwrite((folder.Path() / "c.bmp").string(), mask);
  EXPECT_THAT(Message(FindMaskFiles({"c.jpg"}, folder.Path(), "")), AllOf(HasSubstr("c.bmp"), HasSubstr("c.png")));
}

}  // namespace
}  // namespace rigcal
