#include "config/rig_axes.h"

#include <algorithm>
#include <cctype>
#include <set>

namespace rigcal {
namespace {

constexpr std::string_view kGrblLetters = "XYZ";

/// Whether the controller may call an axis so.
bool IsLetter(const std::string& letter, const std::string& driver) {
  const RigKey& key = *RigTableNamed("positioner.axis").Find("letter", "gantry");
  if (std::ranges::find(key.words, letter) == key.words.end()) return false;
  return driver != "grbl" || kGrblLetters.find(letter) != std::string_view::npos;
}

bool NeedsLetters(const std::string& driver) {
  return driver == "grbl" || driver == "linuxcnc";
}

/// Empty where nothing is usual, or nobody asks.
std::string UsualLetter(const std::string& name, PositionerKind kind, const std::string& driver) {
  if (!NeedsLetters(driver)) return "";
  std::string letter = name;
  std::ranges::transform(letter, letter.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  if (IsLetter(letter, driver)) return letter;
  if (kind != PositionerKind::kTurntable) return "";
  return driver == "grbl" ? "X" : "C";
}

Result<std::vector<std::string>> NamesOf(const CheckedTable& positioner, const std::vector<CheckedTable>& tables,
                                         PositionerKind kind) {
  const bool turntable = kind == PositionerKind::kTurntable;
  std::vector<std::string> names;
  positioner.Read("axes", names);
  if (!names.empty()) return names;
  for (const CheckedTable& table : tables) {
    names.emplace_back(kTableAxis);
    table.Read("name", names.back());
  }
  if (names.empty() && turntable) return std::vector<std::string>{kTableAxis};
  if (names.empty())
    return Fail(ErrorCode::kBadInput, "{}: positioner.axes is missing, the names of one to three", positioner.File());
  const std::size_t most = turntable ? 1 : kMaxGantryAxes;
  if (names.size() > most)
    return Fail(ErrorCode::kBadInput, "{}: {} of [[positioner.axis]], a {} has at most {}", tables[most].Place("name"),
                names.size(), turntable ? "turntable" : "gantry", most);
  return names;
}

Result<void> ReadLimits(const CheckedTable& table, const std::string& key, AxisSettings& axis) {
  std::vector<double> limits;
  table.Read(key, limits);
  if (limits.empty()) return {};
  if (limits[0] >= limits[1])
    return Fail(ErrorCode::kBadInput, "{} of the axis '{}' must be [least, most], the first below the second",
                table.Place(key), axis.name);
  axis.least = limits[0];
  axis.most = limits[1];
  return {};
}

Result<void> ReadAxis(const CheckedTable& table, const std::string& driver, AxisSettings& axis) {
  const bool radian = axis.unit == AxisUnit::kRadian;
  table.Read("letter", axis.device_letter);
  if (table.Has("letter") && !IsLetter(axis.device_letter, driver))
    return Fail(ErrorCode::kBadInput, "{} = \"{}\" of the axis '{}' must be one of the letters {} of grbl",
                table.Place("letter"), axis.device_letter, axis.name, kGrblLetters);
  if (auto read = ReadLimits(table, radian ? "limits_deg" : "limits_m", axis); !read) return read;
  table.Read(radian ? "speed_deg_s" : "speed_m_s", axis.speed);
  const char* backlash = radian ? "backlash_deg" : "backlash_m";
  table.Read(backlash, axis.backlash);
  std::string approach;
  table.Read("approach", approach);
  if (!approach.empty()) axis.approach = approach == "up" ? 1 : -1;
  if (axis.backlash > 0 && axis.approach == 0)
    return Fail(ErrorCode::kBadInput, "{} of the axis '{}' needs approach = \"up\" or \"down\"", table.Place(backlash),
                axis.name);
  return {};
}

Result<void> CheckLetters(const std::vector<AxisSettings>& axes, const CheckedTable& positioner,
                          const std::string& driver) {
  std::set<std::string> letters;
  for (const AxisSettings& axis : axes) {
    if (axis.device_letter.empty())
      return Fail(ErrorCode::kBadInput, "{} = \"{}\": the axis '{}' needs its letter in [[positioner.axis]]",
                  positioner.Place("driver"), driver, axis.name);
    if (!letters.insert(axis.device_letter).second)
      return Fail(ErrorCode::kBadInput, "{} = \"{}\": the axis '{}' has the letter {} of another one",
                  positioner.Place("driver"), driver, axis.name, axis.device_letter);
  }
  return {};
}

}  // namespace

Result<std::vector<AxisSettings>> ReadAxes(const CheckedTable& positioner, const std::vector<CheckedTable>& tables,
                                           PositionerKind kind, const std::string& driver) {
  if (kind == PositionerKind::kArm) {
    if (tables.empty()) return std::vector<AxisSettings>{};
    return Fail(ErrorCode::kBadInput, "{}: an arm has no axes", positioner.Place("axis"));
  }
  const Result<std::vector<std::string>> names = NamesOf(positioner, tables, kind);
  if (!names) return Fail(names.error());
  std::vector<AxisSettings> axes;
  const AxisUnit unit = kind == PositionerKind::kTurntable ? AxisUnit::kRadian : AxisUnit::kMetre;
  for (const std::string& name : *names)
    axes.push_back({.name = name, .device_letter = UsualLetter(name, kind, driver), .unit = unit});
  std::set<std::string> read;
  for (const CheckedTable& table : tables) {
    std::string name = axes.front().name;
    table.Read("name", name);
    const auto axis = std::ranges::find(axes, name, &AxisSettings::name);
    if (axis == axes.end())
      return Fail(ErrorCode::kBadInput, "{} = \"{}\" is not one of positioner.axes", table.Place("name"), name);
    if (!read.insert(name).second)
      return Fail(ErrorCode::kBadInput, "{}: the axis '{}' is there twice", table.Place("name"), name);
    if (auto done = ReadAxis(table, driver, *axis); !done) return Fail(done.error());
  }
  if (NeedsLetters(driver))
    if (auto checked = CheckLetters(axes, positioner, driver); !checked) return Fail(checked.error());
  return axes;
}

}  // namespace rigcal
