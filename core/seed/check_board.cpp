#include "core/seed/check_board.h"

#include "core/seed/tag_family.h"

namespace rigcal {
namespace {

constexpr double kRounding = 1e-9;  // relative, of a gap that is exactly as wide as needed

}  // namespace

Result<void> CheckBoard(const Board& board) {
  const Result<TagFamily> family = TagFamily::Make(board.family, board.border_bits);
  if (!family) return Fail(family.error());
  if (board.columns < 1 || board.rows < 1)
    return Fail(ErrorCode::kBadInput, "columns, rows: a board of {} x {} tags cannot be", board.columns, board.rows);
  const long long last_id = board.first_id + static_cast<long long>(board.columns) * board.rows - 1;
  if (board.first_id < 0 || last_id >= family->NumCodes())
    return Fail(ErrorCode::kBadInput, "first_id: the board needs ids {} to {}, but {} has 0 to {}", board.first_id,
                last_id, board.family, family->NumCodes() - 1);
  if (!(board.tag_m > 0) || !(board.gap_m > 0))
    return Fail(ErrorCode::kBadInput, "tag_m, gap_m: {} and {} must be above 0", board.tag_m, board.gap_m);
  const int needed_cells = family->ReversedBorder() ? family->TotalCells() - family->EdgeCells() : 1;
  const double needed_m = needed_cells * board.tag_m / family->EdgeCells();
  if (board.gap_m < needed_m * (1 - kRounding))
    return Fail(ErrorCode::kBadInput,
                "gap_m: {} is less than the {:.6g} that tags of {} with an edge of {} need between them", board.gap_m,
                needed_m, board.family, board.tag_m);
  return {};
}

}  // namespace rigcal
