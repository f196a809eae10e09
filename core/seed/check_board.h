#pragma once

#include "core/base/result.h"
#include "core/scene/board.h"

namespace rigcal {

/// Whether a board can be: the family is known, its codes suffice, tags and gaps have a size, and what a tag needs
/// around its square (a white ring; data, with a reversed border) fits into the gaps. Messages start with the key that
/// is wrong. Errors: kBadInput.
Result<void> CheckBoard(const Board& board);

}  // namespace rigcal
