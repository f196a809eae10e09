#include "config/rig_key_hints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>
#include <vector>

#include "core/base/joined.h"

namespace rigcal {
namespace {

// How units end names, here and elsewhere.
constexpr std::array<std::string_view, 40> kSuffixes = {
    "_deg", "_rad",   "_mrad", "_deg_s", "_rad_s",  "_rpm",     "_m",   "_mm",      "_cm",      "_um",
    "_in",  "_m_s",   "_mm_s", "_cm_s",  "_mm_min", "_m_min",   "_s",   "_ms",      "_us",      "_ns",
    "_min", "_h",     "_db",   "_px",    "_pixels", "_bytes",   "_kb",  "_mb",      "_gb",      "_gib",
    "_tb",  "_hours", "_days", "_weeks", "_months", "_minutes", "_sec", "_seconds", "_percent", "_mdb"};
constexpr int kMostTypos = 2;
constexpr std::size_t kLeastTyped = 5;  // shorter names are all alike

/// The name without its unit.
std::string Stem(std::string_view name) {
  std::string stem(name);
  std::ranges::transform(stem, stem.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::size_t longest = 0;
  for (const std::string_view suffix : kSuffixes)
    if (stem.size() > suffix.size() && stem.ends_with(suffix)) longest = std::max(longest, suffix.size());
  return stem.substr(0, stem.size() - longest);
}

/// Letters to insert, delete or replace (Levenshtein).
int Typos(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i) + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

/// The key that was probably meant.
const RigKey* Meant(std::string_view name, const RigTable& table, std::string_view kind) {
  const std::string stem = Stem(name);
  const RigKey* nearest = nullptr;
  int fewest = kMostTypos + 1;
  for (const RigKey& key : table.keys) {
    if (!key.IsOf(kind)) continue;
    if (Stem(key.name) == stem) return &key;
    const int typos = Typos(stem, Stem(key.name));
    if (stem.size() >= kLeastTyped && typos < fewest) nearest = &key, fewest = typos;
  }
  return nearest;
}

}  // namespace

std::string WhyUnknown(std::string_view name, const RigTable& table, std::string_view kind) {
  if (const RigKey* meant = Meant(name, table, kind)) {
    const std::string unit = *meant->unit.words == '\0' ? "" : fmt::format(" ({})", meant->unit.words);
    return fmt::format("unknown in {}; did you mean {}{}?", table.Title(), meant->name, unit);
  }
  for (const RigKey& key : table.keys)
    if (key.name == name) return fmt::format("not a key of the kind {}, only of {}", kind, key.of);
  for (const RigTable& other : RigTables())
    if (other.Find(name, kind) != nullptr)
      return fmt::format("unknown in {}; it is a key of {}", table.Title(), other.Title());
  std::vector<std::string> known;
  for (const RigKey& key : table.keys)
    if (key.IsOf(kind)) known.emplace_back(key.name);
  return fmt::format("unknown in {}; known are {}", table.Title(), Joined(known, ", "));
}

}  // namespace rigcal
