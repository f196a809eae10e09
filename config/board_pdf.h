#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/scene/board.h"

namespace rigcal {

struct PaperSize {
  std::string name;  ///< for messages
  double width_mm = 0, height_mm = 0;
};

/// "a4", "a3", upright; nothing for other names.
std::optional<PaperSize> PaperFromName(const std::string& name);

/// A paper just as large as the board needs.
PaperSize PaperFor(const Board& board);

/// Where things are on the page; PDF's own frame: origin lower left, y up.
struct BoardPage {
  double width_mm = 0, height_mm = 0;
  double board_x_mm = 0, board_y_mm = 0;  ///< lower left corner of the lower left tag: the board's origin
  double ruler_mm = 0;                    ///< its length
  bool strip_on_left = false;             ///< ruler and caption stand on the left, turned, instead of below
};

/// The board in the middle of what the ruler and the caption leave of the paper, upright or turned, whichever fits.
/// Errors: kBadInput when neither does, naming the sizes.
Result<BoardPage> LayOutBoard(const Board& board, const PaperSize& paper);

/// A PDF of one page, true to scale, of filled rectangles only: the tags (with border_bits above 1 also the squares in
/// the gaps' corners, as Kalibr prints them), a ruler to check the print and a caption with all numbers. The same board
/// gives the same bytes. Errors: those of LayOutBoard and CheckBoard; kIo when the library fails.
Result<std::string> BoardPdf(const Board& board, const PaperSize& paper);

}  // namespace rigcal
