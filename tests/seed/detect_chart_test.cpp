#include "core/seed/detect_chart.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/seed/find_tags.h"
#include "tests/seed/printed_board.h"

namespace rigcal {
namespace {

struct CornerErrors {
  int count = 0;
  double rms_px = 0;  ///< per axis
  double max_px = 0;
  double in_sigmas = 0;       ///< root mean square of error by stated sigma, per axis
  double towards_tag_px = 0;  ///< mean, towards the centre of the corner's tag
};

class Errors {
 public:
  void Add(const Board& board, const Camera& camera, const Rigid3d& pose, const std::vector<ChartCorner>& corners) {
    for (const ChartCorner& corner : corners) {
      const Eigen::Vector2d truth = TrueCornerPx(board, camera, pose, corner.tag_id, corner.corner);
      const Eigen::Vector2d opposite = TrueCornerPx(board, camera, pose, corner.tag_id, (corner.corner + 2) % 4);
      const Eigen::Vector2d error = corner.x_px - truth;
      ++sum_.count;
      sum_.rms_px += error.squaredNorm() / 2;
      sum_.max_px = std::max(sum_.max_px, error.norm());
      sum_.in_sigmas += error.dot(corner.covariance_px2.inverse() * error) / 2;
      sum_.towards_tag_px += error.dot((opposite - truth).normalized());
    }
  }
  [[nodiscard]] CornerErrors Mean() const {
    CornerErrors mean = sum_;
    mean.rms_px = std::sqrt(sum_.rms_px / sum_.count);
    mean.in_sigmas = std::sqrt(sum_.in_sigmas / sum_.count);
    mean.towards_tag_px /= sum_.count;
    return mean;
  }

 private:
  CornerErrors sum_;
};

const std::vector<Rigid3d>& Poses(const Board& board) {
  static const std::vector<Rigid3d> poses = {LookAt(board, 0.1, -0.05, 0.2, 0.3), LookAt(board, 0.5, 0.3, -0.8, 0.33),
                                             LookAt(board, -0.4, 0.5, 2.4, 0.36)};
  return poses;
}

// Pictures of a board in three poses, each seen by DetectChart.
CornerErrors Measure(const Board& board, const BoardPictureOptions& picture, const ChartOptions& options) {
  Errors errors;
  for (const Rigid3d& pose : Poses(board)) {
    const cv::Mat1f image = RenderBoard(PrintOf(board), TestCamera(), pose, picture);
    const Result<ChartDetection> seen = DetectChart(image, board, options);
    EXPECT_TRUE(seen);
    EXPECT_EQ(seen->num_tags, board.NumTags());
    EXPECT_GE(static_cast<int>(seen->corners.size()), board.NumTags() * kCornersPerTag - 2);
    errors.Add(board, TestCamera(), pose, seen->corners);
  }
  return errors.Mean();
}

TEST(DetectChart, CornersAreExactAndTheirSigmaHonest) {
  for (const Board& board : {StockBoard(), KalibrBoard()}) {
    for (const double noise : {0.004, 0.02}) {
      const CornerErrors e = Measure(board, {.blur_px = 0.6, .noise = noise}, {.linear = true});
      EXPECT_LT(e.rms_px, noise < 0.01 ? 0.02 : 0.05) << board.border_bits;
      EXPECT_LT(e.max_px, 0.15);
      EXPECT_GT(e.in_sigmas, 0.7) << board.border_bits << " " << noise;
      EXPECT_LT(e.in_sigmas, 1.35) << board.border_bits << " " << noise;
      EXPECT_LT(std::abs(e.towards_tag_px), 0.006);
    }
  }
}

TEST(DetectChart, StrongBlurIsFittedToo) {
  // libapriltag's own corners lie more than a pixel towards the dark here.
  const Board board{.columns = 2, .rows = 2, .tag_m = 0.03, .gap_m = 0.009};
  const Rigid3d pose = LookAt(board, 0.2, -0.1, 0.3, 0.16);
  const cv::Mat1f image = RenderBoard(PrintOf(board), TestCamera(), pose, {.blur_px = 2, .noise = 0.004});
  const auto seen = DetectChart(image, board, {.linear = true});
  ASSERT_TRUE(seen);
  ASSERT_EQ(seen->corners.size(), 16U);
  Errors errors;
  errors.Add(board, TestCamera(), pose, seen->corners);
  EXPECT_LT(errors.Mean().rms_px, 0.05);
  EXPECT_LT(std::abs(errors.Mean().towards_tag_px), 0.03);
  EXPECT_NEAR(seen->blur_px, 2, 0.1);
}

TEST(DetectChart, EncodedPicturesAreFittedInLight) {
  const BoardPictureOptions encoded{.blur_px = 0.8, .noise = 0.004, .linear = false};
  const CornerErrors right = Measure(StockBoard(), encoded, {.linear = false});
  EXPECT_LT(right.rms_px, 0.02);
  EXPECT_LT(std::abs(right.towards_tag_px), 0.01);
  EXPECT_LT(right.in_sigmas, 1.35);
  // Taken for light, edges move towards the dark: that is what the option is for. Crossings do not move.
  const CornerErrors wrong = Measure(StockBoard(), encoded, {.linear = true});
  EXPECT_GT(wrong.towards_tag_px, 0.3);
  const CornerErrors crossings = Measure(KalibrBoard(), encoded, {.linear = true});
  EXPECT_LT(std::abs(crossings.towards_tag_px), 0.02);
}

TEST(FindTags, OriginIsTheCentreOfTheFirstPixel) {
  // libapriltag's own corners, before any refinement: half a pixel off in both axes would show.
  const Board board = StockBoard();
  const Rigid3d pose = Poses(board)[0];
  const cv::Mat1f image = RenderBoard(PrintOf(board), TestCamera(), pose, {.blur_px = 0.5});
  cv::Mat1b bits;
  image.convertTo(bits, CV_8U, 255);
  const std::vector<FoundTag> tags = FindTags(bits, *TagFamily::Make(board.family, 1));
  ASSERT_EQ(static_cast<int>(tags.size()), board.NumTags());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const FoundTag& tag : tags)
    for (int k = 0; k < kCornersPerTag; ++k)
      mean +=
          (tag.corners_px[k] - TrueCornerPx(board, TestCamera(), pose, tag.id, k)) / (kCornersPerTag * board.NumTags());
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.08);
}

class EveryFamily : public ::testing::TestWithParam<const char*> {};

TEST_P(EveryFamily, IsFoundUpright) {
  Board board{.family = GetParam(), .columns = 2, .rows = 2, .tag_m = 0.03, .gap_m = 0.04, .first_id = 5};
  const Rigid3d pose = LookAt(board, 0.2, 0.2, 0.4, 0.3);
  const cv::Mat1f image = RenderBoard(PrintOf(board), TestCamera(), pose, {.blur_px = 0.5, .noise = 0.004});
  const Result<ChartDetection> seen = DetectChart(image, board, {.linear = true});
  ASSERT_TRUE(seen) << seen.error().message;
  ASSERT_EQ(seen->corners.size(), 16U);
  Errors errors;
  errors.Add(board, TestCamera(), pose, seen->corners);
  EXPECT_LT(errors.Mean().max_px, 0.06);
}

// The two families with tens of thousands of codes need a second and more each to set up; one stands for both.
INSTANTIATE_TEST_SUITE_P(All, EveryFamily,
                         ::testing::Values("tag36h11", "tag16h5", "tag25h9", "tag36h10", "tagCircle21h7",
                                           "tagCustom48h12", "tagStandard41h12"));

TEST(DetectChart, RepeatsByteForByte) {
  const Board board = KalibrBoard();
  const cv::Mat1f image = RenderBoard(PrintOf(board), TestCamera(), Poses(board)[1], {.noise = 0.01});
  const auto first = DetectChart(image, board), second = DetectChart(image, board);
  ASSERT_TRUE(first && second);
  ASSERT_EQ(first->corners.size(), second->corners.size());
  for (std::size_t i = 0; i < first->corners.size(); ++i) {
    EXPECT_EQ(first->corners[i].x_px, second->corners[i].x_px);
    EXPECT_EQ(first->corners[i].covariance_px2, second->corners[i].covariance_px2);
  }
}

// A tag whose border is broken is no square for libapriltag, but its code stands where its neighbours tell.
BoardPrint WithBrokenBorder(BoardPrint print, int tag) {
  cv::Mat1b& cells = print.cells[tag];
  cells(cells.rows / 2, 1) = cells(cells.rows / 2, 2) = 255;
  return print;
}

TEST(DetectChart, FindsWhatTheNeighboursPredict) {
  const Board board = KalibrBoard();
  const cv::Mat1f image =
      RenderBoard(WithBrokenBorder(PrintOf(board), 5), TestCamera(), Poses(board)[1], {.blur_px = 0.6, .noise = 0.004});
  const auto alone = DetectChart(image, board, {.linear = true, .predict = false});
  const auto predicted = DetectChart(image, board, {.linear = true});
  ASSERT_TRUE(alone && predicted);
  EXPECT_EQ(alone->num_tags, board.NumTags() - 1);
  EXPECT_EQ(predicted->num_tags, board.NumTags());
  EXPECT_EQ(predicted->num_predicted, 1);
  Errors errors;
  errors.Add(board, TestCamera(), Poses(board)[1], predicted->corners);
  EXPECT_LT(errors.Mean().max_px, 0.15);
}

TEST(DetectChart, PredictsNothingThatIsNotThere) {
  const Board board = KalibrBoard();
  BoardPrint print = WithBrokenBorder(PrintOf(board), 5);
  print.cells[5] = TagFamily::Make(board.family, 2)->Cells(300);  // another tag in its place
  print.cells[6] = cv::Mat1b(print.cells[6].size(), 0);           // a black square
  const cv::Mat1f image = RenderBoard(print, TestCamera(), Poses(board)[1], {.blur_px = 0.6, .noise = 0.004});
  const auto seen = DetectChart(image, board, {.linear = true});
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->num_tags, board.NumTags() - 2);
  for (const ChartCorner& corner : seen->corners) EXPECT_TRUE(corner.tag_id != 5 && corner.tag_id != 6);
}

TEST(DetectChart, LeavesAHiddenCornerOut) {
  const Board board = StockBoard();
  const Rigid3d pose = Poses(board)[0];
  cv::Mat1f image = RenderBoard(PrintOf(board), TestCamera(), pose, {.blur_px = 0.6, .noise = 0.004});
  const Eigen::Vector2d hidden = TrueCornerPx(board, TestCamera(), pose, 6, 2);
  for (int y = -2; y <= 2; ++y)
    for (int x = -2; x <= 2; ++x) image(static_cast<int>(hidden.y()) + y, static_cast<int>(hidden.x()) + x + 1) = 0.45f;
  const auto seen = DetectChart(image, board, {.linear = true});
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->num_tags, board.NumTags());
  for (const ChartCorner& corner : seen->corners) EXPECT_FALSE(corner.tag_id == 6 && corner.corner == 2);
  Errors errors;
  errors.Add(board, TestCamera(), pose, seen->corners);
  EXPECT_LT(errors.Mean().max_px, 0.2);
}

}  // namespace
}  // namespace rigcal
