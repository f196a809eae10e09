#include "config/board_file.h"

#include <array>
#include <limits>
#include <optional>
#include <variant>

#include "config/atomic_file.h"
#include "config/toml_content.h"
#include "core/seed/check_board.h"
#include "core/seed/tag_family.h"

namespace rigcal {
namespace {

constexpr int kMaxTagsAcross = 256;
constexpr double kMinTagM = 0.0005, kMaxTagM = 5;
constexpr double kMaxThicknessM = 0.5;
// Families with data around their square need up to 1.2 edges between tags; wider gaps waste the board.
constexpr double kMaxGapShare = 2;

using Member = std::variant<std::string Board::*, int Board::*, double Board::*>;

/// One key of the file: the only place where keys and ranges stand.
struct Key {
  std::string_view name;
  Member member;
  double least = 0, most = 0;
  bool required = true;
};

constexpr std::array<Key, 8> kKeys = {{
    {"family", &Board::family},
    {"border_bits", &Board::border_bits, 1, TagFamily::kMaxBorderBits, false},
    {"columns", &Board::columns, 1, kMaxTagsAcross},
    {"rows", &Board::rows, 1, kMaxTagsAcross},
    {"tag_m", &Board::tag_m, kMinTagM, kMaxTagM},
    {"gap_m", &Board::gap_m, std::numeric_limits<double>::min(), kMaxGapShare* kMaxTagM},
    {"first_id", &Board::first_id, 0, std::numeric_limits<int>::max() / 2, false},
    {"thickness_m", &Board::thickness_m, 0, kMaxThicknessM, false},
}};

Result<void> ReadKey(const Key& key, const toml::node& node, const std::string& file, Board& board) {
  const std::string where = KeyPlace(file, node, key.name);
  if (const auto* text = std::get_if<std::string Board::*>(&key.member)) {
    if (!node.is_string())
      return Fail(ErrorCode::kBadInput, "{} must be a text in quotes, a family of AprilTags", where);
    board.*(*text) = node.ref<std::string>();
    return {};
  }
  const bool whole = std::holds_alternative<int Board::*>(key.member);
  const Result<double> value = TomlNumber(node, where, {key.least, key.most, whole, whole ? "" : "metres"});
  if (!value) return Fail(value.error());
  if (whole)
    board.*std::get<int Board::*>(key.member) = static_cast<int>(*value);
  else
    board.*std::get<double Board::*>(key.member) = *value;
  return {};
}

Result<void> CheckGap(const toml::table& table, const std::string& file, const Board& board) {
  if (board.gap_m <= kMaxGapShare * board.tag_m) return {};
  std::string message =
      fmt::format("{} = {} is more than {:.4g} (twice tag_m)", KeyPlace(file, *table.get("gap_m"), "gap_m"),
                  board.gap_m, kMaxGapShare * board.tag_m);
  if (board.gap_m <= 1)
    message += fmt::format("; it looks like Kalibr's spacing ratio mistaken for a length, which would be {:.6g} m",
                           board.gap_m * board.tag_m);
  return Fail(ErrorCode::kBadInput, "{}", message);
}

// The first key that a message of CheckBoard names, so that its line can be told.
std::string_view NamedKey(const std::string& message) {
  return std::string_view(message).substr(0, message.find_first_of(",:"));
}

}  // namespace

Result<Board> ParseBoard(std::string_view text, const std::string& file) {
  const Result<toml::table> parsed = ParseToml(text, file);
  if (!parsed) return Fail(parsed.error());
  const toml::table& table = *parsed;
  std::vector<std::string> known;
  for (const Key& key : kKeys) known.emplace_back(key.name);
  if (auto checked = CheckKeys(table, file, "a board file", known); !checked) return Fail(checked.error());
  Board board;
  for (const Key& key : kKeys) {
    const toml::node* node = table.get(key.name);
    if (node == nullptr && key.required) return Fail(ErrorCode::kBadInput, "{}: {} is missing", file, key.name);
    if (node == nullptr) continue;
    if (const Result<void> read = ReadKey(key, *node, file, board); !read) return Fail(read.error());
  }
  if (const Result<void> gap = CheckGap(table, file, board); !gap) return Fail(gap.error());
  if (const Result<void> checked = CheckBoard(board); !checked) {
    const toml::node* node = table.get(NamedKey(checked.error().message));
    const std::size_t line = node == nullptr ? 1 : node->source().begin.line;
    return Fail(ErrorCode::kBadInput, "{} line {}: {}", file, line, checked.error().message);
  }
  return board;
}

std::string BoardText(const Board& board) {
  return fmt::format(
      "# A board of AprilTags. Lengths in metres; ids count from the lower left, row by row upwards.\n"
      "family = \"{}\"\nborder_bits = {}\ncolumns = {}\nrows = {}\n"
      "tag_m = {}  # edge of a tag's square\ngap_m = {}  # between the squares of neighbours\nfirst_id = {}\n"
      "thickness_m = {}  # from the print to the table\n",
      board.family, board.border_bits, board.columns, board.rows, board.tag_m, board.gap_m, board.first_id,
      board.thickness_m);
}

Result<void> SaveBoard(const std::filesystem::path& path, const Board& board) {
  return WriteFileAtomically(path, BoardText(board));
}

}  // namespace rigcal
