#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "core/seed/detect_chart.h"
#include "tests/seed/printed_board.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

cv::Mat1f Picture(const Board& board, const BoardPictureOptions& options = {.blur_px = 0.5, .noise = 0.004}) {
  return RenderBoard(PrintOf(board), TestCamera(), LookAt(board, 0.3, 0.2, 0.4, 0.33), options);
}

ChartDetection See(const cv::Mat1f& picture, const Board& board) {
  const Result<ChartDetection> seen = DetectChart(picture, board, {.linear = true});
  EXPECT_TRUE(seen);
  return seen ? *seen : ChartDetection{};
}

void ExpectUnusable(const ChartDetection& seen, ChartFindingKind kind, const std::vector<std::string>& parts) {
  EXPECT_TRUE(seen.corners.empty());
  ASSERT_FALSE(seen.findings.empty());
  const ChartFinding& finding = seen.findings.back();
  EXPECT_EQ(finding.kind, kind) << finding.message;
  EXPECT_TRUE(finding.unusable);
  for (const std::string& part : parts) EXPECT_THAT(finding.message, HasSubstr(part));
}

TEST(ChartFindings, ARatioGivenAsALengthIsNamed) {
  const Board board = KalibrBoard();
  Board wrong = board;
  wrong.gap_m = 0.3;  // of 30 mm
  ExpectUnusable(See(Picture(board), wrong), ChartFindingKind::kSpacing, {"spacing ratio", "0.009"});
}

TEST(ChartFindings, AGapThatDoesNotFitIsNamed) {
  const Board board = StockBoard();
  Board wrong = board;
  wrong.gap_m *= 1.2;  // the pitch by 4.6 %
  ExpectUnusable(See(Picture(board), wrong), ChartFindingKind::kSpacing, {"0.299", "0.360"});
}

TEST(ChartFindings, IdsThatRunOtherwiseAreNamed) {
  const Board board = StockBoard();
  Board wrong = board;
  std::swap(wrong.columns, wrong.rows);
  EXPECT_TRUE(See(Picture(board), wrong).corners.empty());
  BoardPrint downwards = PrintOf(board);
  for (int column = 0; column < board.columns; ++column)
    std::swap(downwards.cells[column], downwards.cells[2 * board.columns + column]);
  const cv::Mat1f picture = RenderBoard(downwards, TestCamera(), LookAt(board, 0.3, 0.2, 0.4, 0.33), {});
  ExpectUnusable(See(picture, board), ChartFindingKind::kLayout, {"4 columns"});
}

TEST(ChartFindings, ForeignIdsAreNamedAndLeftOut) {
  Board board = StockBoard();
  const cv::Mat1f picture = Picture(board);
  board.rows = 2;
  const ChartDetection seen = See(picture, board);
  EXPECT_EQ(seen.num_tags, 8);
  ASSERT_FALSE(seen.findings.empty());
  EXPECT_EQ(seen.findings[0].kind, ChartFindingKind::kForeignIds);
  EXPECT_THAT(seen.findings[0].message, HasSubstr("8, 9, 10, 11"));
}

TEST(ChartFindings, TwoBoardsWithTheSameIds) {
  const Board board = StockBoard();
  cv::Mat1f both;
  cv::hconcat(Picture(board), Picture(board), both);
  ExpectUnusable(See(both, board), ChartFindingKind::kDoubledIds, {"two boards"});
}

TEST(ChartFindings, OneDoubledTagIsLeftOut) {
  const Board board = StockBoard();
  Board single = board;
  single.columns = single.rows = 1;
  single.first_id = 3;
  cv::Mat1f both;
  cv::hconcat(Picture(board), RenderBoard(PrintOf(single), TestCamera(), LookAt(single, 0, 0, 0, 0.3), {}), both);
  const ChartDetection seen = See(both, board);
  EXPECT_EQ(seen.num_tags, board.NumTags());
  EXPECT_EQ(seen.findings[0].kind, ChartFindingKind::kDoubledIds);
  for (const ChartCorner& corner : seen.corners) EXPECT_LT(corner.x_px.x(), 400);
}

TEST(ChartFindings, AMirrorImage) {
  const Board board = StockBoard();
  cv::Mat1f mirrored;
  cv::flip(Picture(board), mirrored, 1);
  ExpectUnusable(See(mirrored, board), ChartFindingKind::kMirrored, {"mirror"});
}

TEST(ChartFindings, AnotherFamilyOrBorder) {
  const Board board = StockBoard();
  Board other = board;
  other.family = "tag25h9";
  ExpectUnusable(See(Picture(board), other), ChartFindingKind::kOtherFamily, {"tag36h11", "tag25h9"});
  other = board;
  other.border_bits = 2;
  ExpectUnusable(See(Picture(board), other), ChartFindingKind::kOtherFamily, {"border_bits 1", "border_bits 2"});
}

TEST(ChartFindings, NothingToSee) {
  const Board board = StockBoard();
  ExpectUnusable(See(cv::Mat1f(300, 400, 0.3f), board), ChartFindingKind::kNothingSeen, {"no tag"});
  ExpectUnusable(See(cv::Mat1f(300, 400, 1.f), board), ChartFindingKind::kNothingSeen, {"over-exposed"});
  ExpectUnusable(See(Picture(board, {.blur_px = 9}), board), ChartFindingKind::kNothingSeen, {"blurred"});
}

TEST(ChartFindings, BoardsThatCannotBeAreErrors) {
  Board board = StockBoard();
  board.first_id = 580;
  const Result<ChartDetection> seen = DetectChart(cv::Mat1f(30, 40, 0.3f), board);
  ASSERT_FALSE(seen);
  EXPECT_THAT(seen.error().message, HasSubstr("591"));
  EXPECT_FALSE(DetectChart(cv::Mat1f(), StockBoard()));
}

}  // namespace
}  // namespace rigcal
