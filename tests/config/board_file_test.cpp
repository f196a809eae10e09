#include "config/board_file.h"

#include <gtest/gtest.h>

#include "config/read_file.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

constexpr const char* kKalibr =
    "family = \"tag36h11\"\nborder_bits = 2\ncolumns = 6\nrows = 6\ntag_m = 0.088\ngap_m = 0.0264\n"
    "first_id = 0\nthickness_m = 0.004\n";

void ExpectTextRefused(const std::string& text, const std::vector<std::string>& parts) {
  SCOPED_TRACE(text);
  ExpectRefused(ParseBoard(text, "board.toml"), parts);
}

TEST(BoardFile, ReadsEveryKey) {
  const Result<Board> board = ParseBoard(kKalibr, "board.toml");
  ASSERT_TRUE(board) << board.error().message;
  EXPECT_EQ(board->family, "tag36h11");
  EXPECT_EQ(board->border_bits, 2);
  EXPECT_EQ(board->NumTags(), 36);
  EXPECT_DOUBLE_EQ(board->tag_m, 0.088);
  EXPECT_DOUBLE_EQ(board->gap_m, 0.0264);
  EXPECT_DOUBLE_EQ(board->thickness_m, 0.004);
}

TEST(BoardFile, WhatIsSavedReadsBack) {
  const TemporaryFolder folder;
  const Board board{"tagStandard41h12", 1, 3, 2, 0.1 / 3, 0.03, 7, 0.0021};
  ASSERT_TRUE(SaveBoard(folder.Path() / "board.toml", board));
  const Result<std::string> text = ReadFile(folder.Path() / "board.toml");
  ASSERT_TRUE(text) << text.error().message;
  const Result<Board> read = ParseBoard(*text, "board.toml");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->family, board.family);
  EXPECT_EQ(read->tag_m, board.tag_m);
  EXPECT_EQ(read->thickness_m, board.thickness_m);
  EXPECT_EQ(read->first_id, 7);
  EXPECT_EQ(BoardText(*read), BoardText(board));
}

TEST(BoardFile, NamesFileLineKeyAndRange) {
  ExpectTextRefused(Replaced(kKalibr, "rows = 6", "rows = 600"), {"board.toml line 4: rows", "600", "1 to 256"});
  ExpectTextRefused(Replaced(kKalibr, "rows = 6", "rows = 6.5"), {"line 4: rows", "whole number"});
  ExpectTextRefused(Replaced(kKalibr, "0.088", "\"88 mm\""), {"line 5: tag_m", "metres"});
  ExpectTextRefused(Replaced(kKalibr, "0.088", "88"), {"line 5: tag_m", "88", "0.0005 to 5"});
  ExpectTextRefused(Replaced(kKalibr, "0.088", "nan"), {"line 5: tag_m"});
  ExpectTextRefused(Replaced(kKalibr, "border_bits = 2", "border_bits = 0"), {"line 2: border_bits", "1 to 4"});
  ExpectTextRefused(Replaced(kKalibr, "\"tag36h11\"", "36"), {"line 1: family", "text"});
  ExpectTextRefused(Replaced(kKalibr, "tag36h11", "tag37h11"), {"line 1", "tag37h11", "tag36h11"});
  ExpectTextRefused(Replaced(kKalibr, "first_id = 0", "first_id = 580"), {"line 7: first_id", "615", "586"});
}

TEST(BoardFile, RefusesUnknownAndMissingKeys) {
  ExpectTextRefused(Replaced(kKalibr, "gap_m", "spacing"), {"line 6: spacing", "gap_m"});
  ExpectTextRefused(Replaced(kKalibr, "columns = 6\n", ""), {"columns is missing"});
  ExpectTextRefused("columns = \n", {"line 1", "not TOML"});
}

TEST(BoardFile, NoticesASpacingRatioGivenAsALength) {
  ExpectTextRefused(Replaced(kKalibr, "0.0264", "0.3"), {"line 6: gap_m", "spacing ratio", "0.0264 m"});
}

TEST(BoardFile, RefusesGapsThatTheTagsDoNotFitInto) {
  ExpectTextRefused(Replaced(kKalibr, "0.0264", "0.005"), {"line 6: gap_m", "0.0088"});
  ExpectTextRefused(Replaced(Replaced(kKalibr, "border_bits = 2", "border_bits = 1"), "tag36h11", "tagStandard41h12"),
                    {"gap_m", "0.0704"});
}

}  // namespace
}  // namespace rigcal
