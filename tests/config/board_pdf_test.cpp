#include "config/board_pdf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/seed/detect_chart.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

constexpr double kDotsPerInch = 200;
constexpr double kMmPerDot = 25.4 / kDotsPerInch;
// Poppler smooths edges with 4 x 4 points in a dot, so that one along the grid may be off by a quarter of a dot.
constexpr double kToleranceMm = 0.35 * kMmPerDot;

// Edges along the grid without any blur tell their place only to a dot.
constexpr double kLensBlurDots = 0.7;

Board StockBoard() {
  return {.columns = 5, .rows = 6, .tag_m = 0.03, .gap_m = 0.009};
}

// Poppler draws pages of its own accord: another program than the one that wrote them.
cv::Mat1f Rendered(const std::string& pdf, const TemporaryFolder& folder) {
  const std::string file = folder.Write("board.pdf", pdf).string(), stem = (folder.Path() / "page").string();
  const std::string command = fmt::format("pdftoppm -r {} -gray -png -singlefile {} {}", kDotsPerInch, file, stem);
  EXPECT_EQ(std::system(command.c_str()), 0);
  cv::Mat1f page;
  cv::imread(stem + ".png", cv::IMREAD_GRAYSCALE).convertTo(page, CV_32F, 1.0 / 255);
  cv::GaussianBlur(page, page, {0, 0}, kLensBlurDots);
  return page;
}

void ExpectTrueToScale(const Board& board, const PaperSize& paper) {
  const TemporaryFolder folder;
  const Result<std::string> pdf = BoardPdf(board, paper);
  ASSERT_TRUE(pdf) << pdf.error().message;
  const BoardPage layout = *LayOutBoard(board, paper);
  const cv::Mat1f page = Rendered(*pdf, folder);
  EXPECT_NEAR(page.cols * kMmPerDot, layout.width_mm, 2 * kMmPerDot);
  const Result<ChartDetection> seen = DetectChart(page, board, {.linear = true});
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->num_tags, board.NumTags());
  EXPECT_EQ(static_cast<int>(seen->corners.size()), kCornersPerTag * board.NumTags()) << board.family;
  for (const ChartFinding& finding : seen->findings) ADD_FAILURE() << finding.message;
  for (const ChartCorner& corner : seen->corners) {
    const Eigen::Vector3d x_m = TagCornerInBoard(board, corner.tag_id, corner.corner);
    // Dots count from the page's upper left corner, the first one's centre is half a dot inside.
    EXPECT_NEAR((corner.x_px.x() + 0.5) * kMmPerDot, layout.board_x_mm + 1e3 * x_m.x(), kToleranceMm);
    EXPECT_NEAR(layout.height_mm - (corner.x_px.y() + 0.5) * kMmPerDot, layout.board_y_mm + 1e3 * x_m.y(),
                kToleranceMm);
  }
}

TEST(BoardPdf, TagsLieWhereTheBoardHasThem) {
  ExpectTrueToScale(StockBoard(), *PaperFromName("a4"));
}

TEST(BoardPdf, KalibrAndReversedBorders) {
  const Board kalibr{.border_bits = 2, .columns = 3, .rows = 2, .tag_m = 0.04, .gap_m = 0.012};
  ExpectTrueToScale(kalibr, PaperFor(kalibr));
  const Board standard{.family = "tagStandard41h12", .columns = 3, .rows = 2, .tag_m = 0.03, .gap_m = 0.03};
  ExpectTrueToScale(standard, *PaperFromName("a4"));
}

TEST(BoardPdf, TurnsThePaper) {
  Board wide = StockBoard();
  std::swap(wide.columns, wide.rows);
  const Result<BoardPage> layout = LayOutBoard(wide, *PaperFromName("a4"));
  ASSERT_TRUE(layout) << layout.error().message;
  EXPECT_GT(layout->width_mm, layout->height_mm);
  EXPECT_TRUE(layout->strip_on_left);  // 209.5 of 210 mm are the board's
  ExpectTrueToScale(wide, *PaperFromName("a4"));
}

TEST(BoardPdf, RefusesWhatDoesNotFit) {
  Board large = StockBoard();
  large.rows = 8;
  const Result<std::string> pdf = BoardPdf(large, *PaperFromName("a4"));
  ASSERT_FALSE(pdf);
  EXPECT_THAT(pdf.error().message, HasSubstr("A4 has 210 x 297 mm"));
  EXPECT_THAT(pdf.error().message, HasSubstr("326.5"));  // 8 tags, 7 gaps, rings and margins
  EXPECT_TRUE(BoardPdf(large, *PaperFromName("a3")));
  EXPECT_TRUE(BoardPdf(large, PaperFor(large)));
}

TEST(BoardPdf, IsRepeatableAndHoldsNoImage) {
  const auto first = BoardPdf(StockBoard(), *PaperFromName("a4")),
             second = BoardPdf(StockBoard(), *PaperFromName("a4"));
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second);
  EXPECT_EQ(first->find("/Subtype /Image"), std::string::npos);
}

}  // namespace
}  // namespace rigcal
