#include <fmt/format.h>

#include "config/rig_keys.h"

namespace rigcal {
namespace {

std::string Cell(std::string_view text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c;
  }
  return cell;
}

std::string Row(const RigKey& key, bool kinds) {
  const std::string of = kinds ? fmt::format("{} | ", key.of) : "";
  return fmt::format("| `{}` | {}{} | {} | {} |\n", key.name, of, Cell(key.meaning), Cell(KeyDescription(key)),
                     Cell(key.fallback));
}

std::string Section(const RigTable& table) {
  bool kinds = false;
  for (const RigKey& key : table.keys) kinds = kinds || !key.of.empty();
  std::string text = fmt::format("\n## `{}`\n\n{}{}\n\n", table.Title(), table.meaning,
                                 table.repeated ? " The table may stand several times." : "");
  text += kinds ? "| key | of | what | must be | default |\n|---|---|---|---|---|\n"
                : "| key | what | must be | default |\n|---|---|---|---|\n";
  for (const RigKey& key : table.keys) text += Row(key, kinds);
  return text;
}

}  // namespace

std::string RigKeysMarkdown() {
  std::string text =
      "# Keys of rig.toml\n\n"
      "Printed by `rigcal rig keys`, from the table by which the file is checked. [Rig files](rig.md) says what they "
      "are\n"
      "for. Every other key, another unit and a value out of its range are refused with file, line, key and range. A "
      "unit\n"
      "is in the name of its key. Only `[positioner]` with `kind` must be there. \"of\" is the kind of positioner that "
      "has\n"
      "the key; all have it where nothing stands there.\n";
  for (const RigTable& table : RigTables()) text += Section(table);
  return text;
}

}  // namespace rigcal
