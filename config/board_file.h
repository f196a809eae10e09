#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/scene/board.h"

namespace rigcal {

/// Reads the text of a board.toml: family, columns, rows, tag_m, gap_m; border_bits, first_id and thickness_m when they
/// are not as in Board. `file` names it in messages, which tell line, key and allowed range. Errors: kBadInput: not
/// TOML, a key that is unknown or missing, a value of the wrong type or out of range, a board that cannot be
/// (CheckBoard), a spacing ratio given as a length.
Result<Board> ParseBoard(std::string_view text, const std::string& file);

/// The text of a board.toml with every key. Reads back as the same board.
std::string BoardText(const Board& board);

/// Writes BoardText, whole or not at all. Errors: kIo, kDiskFull.
Result<void> SaveBoard(const std::filesystem::path& path, const Board& board);

}  // namespace rigcal
