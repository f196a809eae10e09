#pragma once

#include <numbers>
#include <span>
#include <string>
#include <string_view>

namespace rigcal {

/// What a key of rig.toml holds.
enum class KeyType {
  kText,
  kName,    ///< goes into file names: letters, digits, '-' and '_'
  kWord,    ///< one of RigKey::words
  kFlag,    ///< true or false
  kNumber,  ///< a list of them with kNumbers
  kWhole,   ///< a list of them with kWholes
  kNumbers,
  kWholes,
  kNumberRows,  ///< a list of lists of numbers
  kTexts,       ///< different texts
};

/// How the name of a key ends that has a unit, and what the program holds instead.
struct KeyUnit {
  std::string_view suffix;
  const char* words = "";
  double to_si = 1;  ///< what is held, for one of the unit
};
inline constexpr double kRadPerDeg = std::numbers::pi / 180, kBytesPerGb = 1e9;
inline constexpr KeyUnit kPlain{""}, kDegrees{"_deg", "degrees", kRadPerDeg}, kMetres{"_m", "metres"},
    kDegreesPerSecond{"_deg_s", "degrees per second", kRadPerDeg}, kMetresPerSecond{"_m_s", "metres per second"},
    kSeconds{"_s", "seconds"}, kMicroseconds{"_us", "microseconds"}, kDecibels{"_db", "decibels"},
    kPixels{"_px", "pixels"}, kBytes{"_bytes", "bytes"}, kDays{"_days", "days"},
    kGigabytes{"_gb", "gigabytes of 10^9 bytes", kBytesPerGb};

/// Characters of a kText, which a recording must be able to hold, and of a kName.
inline constexpr int kMaxTextLength = 256, kMaxNameLength = 64;

/// RigKey::fallback of a key that must be there.
inline constexpr std::string_view kRequired = "required";

/// One key of one table: the only place where its name, type, unit, range and default stand.
struct RigKey {
  std::string_view name;
  KeyType type = KeyType::kText;
  KeyUnit unit = kPlain;
  double least = 0, most = 0;               ///< of every number
  int fewest = 0, longest = 0;              ///< of a list
  std::span<const std::string_view> words;  ///< of a kWord
  std::string_view fallback;                ///< as it would stand in the file; or in words; or kRequired
  std::string_view meaning;
  std::string_view of;  ///< the one kind of positioner that has it, or several with ", "; empty: all

  [[nodiscard]] bool IsOf(std::string_view kind) const;
};

/// A table of rig.toml. A key may have a row for each kind of positioner.
struct RigTable {
  std::string_view name;  ///< "camera", "positioner.axis"
  bool repeated = false;  ///< [[camera]]: one for each
  std::span<const RigKey> keys;
  std::string_view meaning;

  /// "[positioner]" or "[[camera]]".
  [[nodiscard]] std::string Title() const;
  /// The row of a key for a kind of positioner; nothing when it has none.
  [[nodiscard]] const RigKey* Find(std::string_view key, std::string_view kind) const;
};

/// "a number in degrees from 0 to 10", "one of \"up\", \"down\"": what a key's value must be.
std::string KeyDescription(const RigKey& key);

/// All tables, in the order of the documentation.
std::span<const RigTable> RigTables();
/// One of them by its name, which must be there.
const RigTable& RigTableNamed(std::string_view name);

/// docs/rig_keys.md.
std::string RigKeysMarkdown();

}  // namespace rigcal
