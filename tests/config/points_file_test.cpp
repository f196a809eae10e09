#include "config/points_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(PointsFile, WithAndWithoutViews) {
  const auto points = ParsePoints("# object\n1 2 3\n\n-1 0.5 1e-3 2 0 4\n", "points.txt", 5);
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_EQ(points->size(), 2U);
  EXPECT_EQ((*points)[0].x_in_world, Eigen::Vector3d(1, 2, 3));
  EXPECT_THAT((*points)[0].views, IsEmpty());
  EXPECT_EQ((*points)[1].x_in_world, Eigen::Vector3d(-1, 0.5, 1e-3));
  EXPECT_THAT((*points)[1].views, ElementsAre(0, 4));
}

TEST(PointsFile, ErrorsNameTheLine) {
  const auto message = [](const std::string& text) {
    const auto points = ParsePoints(text, "points.txt", 5);
    return points ? "read" : points.error().message;
  };
  EXPECT_THAT(message("1 2 3\n1 2\n"), HasSubstr("points.txt line 2"));
  EXPECT_THAT(message("1 2 x\n"), HasSubstr("'x'"));
  EXPECT_THAT(message("1 2 3 2 0\n"), HasSubstr("announces 2"));
  EXPECT_THAT(message("1 2 3 1 5\n"), HasSubstr("view 5"));
  EXPECT_THAT(message("1 2 3 1 -1\n"), HasSubstr("'-1'"));
}

}  // namespace
}  // namespace rigcal
