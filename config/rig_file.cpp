#include "config/rig_file.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>

#include "config/positioner_names.h"
#include "config/toml_content.h"
#include "core/base/joined.h"

namespace rigcal {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kMaxSigmaDeg = 10, kMaxSigmaM = 0.1;  // beyond, a position says nothing
constexpr double kMaxScaleSigma = 0.1;

/// The expected size of some components of a StopError: the only place where these keys and their ranges stand.
struct SigmaKey {
  std::string_view name;
  PositionerKind kind;
  int first, count;
  double to_si;
  NumberRange range;
};
constexpr NumberRange kDegrees{0, kMaxSigmaDeg, false, "degrees"}, kMetres{0, kMaxSigmaM, false, "metres"};
constexpr std::array<SigmaKey, 7> kSigmas = {{
    {"step_sigma_deg", PositionerKind::kTurntable, kStep, 1, kRadPerDeg, kDegrees},
    {"wobble_sigma_deg", PositionerKind::kTurntable, kWobbleX, 2, kRadPerDeg, kDegrees},
    {"run_out_sigma_m", PositionerKind::kTurntable, kRunOutX, 2, 1, kMetres},
    {"lift_sigma_m", PositionerKind::kTurntable, kLift, 1, 1, kMetres},
    {"position_sigma_m", PositionerKind::kGantry, 3, 3, 1, kMetres},
    {"position_sigma_m", PositionerKind::kArm, 3, 3, 1, kMetres},
    {"rotation_sigma_deg", PositionerKind::kArm, 0, 3, kRadPerDeg, kDegrees},
}};
constexpr std::string_view kAxisScale = "axis_scale_sigma";

/// One of a few words; `fallback` when the key is not there.
template <typename Value, std::size_t kCount>
Result<Value> WordFrom(const toml::table& table, std::string_view key, const std::string& file,
                       const std::array<std::pair<std::string_view, Value>, kCount>& words,
                       std::optional<Value> fallback) {
  std::vector<std::string> quoted;
  for (const auto& [word, value] : words) quoted.push_back(fmt::format("\"{}\"", word));
  const std::string known = Joined(quoted, ", ");
  const toml::node* node = table.get(key);
  if (node == nullptr && fallback) return *fallback;
  if (node == nullptr) return Fail(ErrorCode::kBadInput, "{}: positioner.{} is missing, one of {}", file, key, known);
  for (const auto& [word, value] : words) {
    if (node->is_string() && node->ref<std::string>() == word) return value;
  }
  return Fail(ErrorCode::kBadInput, "{} must be one of {}", KeyPlace(file, *node, key), known);
}

Result<std::vector<std::string>> AxesFrom(const toml::table& table, const std::string& file, PositionerKind kind) {
  const toml::node* node = table.get("axes");
  if (kind == PositionerKind::kArm) {
    if (node != nullptr) return Fail(ErrorCode::kBadInput, "{}: an arm has none", KeyPlace(file, *node, "axes"));
    return std::vector<std::string>{};
  }
  const bool turntable = kind == PositionerKind::kTurntable;
  if (node == nullptr && turntable) return std::vector<std::string>{kTableAxis};
  if (node == nullptr) return Fail(ErrorCode::kBadInput, "{}: positioner.axes is missing, the names of 1 to 3", file);
  std::vector<std::string> axes;
  if (const toml::array* names = node->as_array()) {
    for (const toml::node& name : *names) {
      if (!name.is_string() || std::ranges::find(axes, name.ref<std::string>()) != axes.end()) {
        return Fail(ErrorCode::kBadInput, "{} must be different names in quotes", KeyPlace(file, *node, "axes"));
      }
      axes.push_back(name.ref<std::string>());
    }
  }
  const std::size_t most = turntable ? 1 : kMaxGantryAxes;
  if (axes.empty() || axes.size() > most) {
    return Fail(ErrorCode::kBadInput, "{} must be a list of {} in quotes", KeyPlace(file, *node, "axes"),
                turntable ? "one name" : "one to three names");
  }
  return axes;
}

RigModel ModelOf(PositionerKind kind, PositionerLoad load, int num_axes) {
  switch (kind) {
    case PositionerKind::kTurntable:
      return Turntable();
    case PositionerKind::kGantry:
      return Gantry(num_axes, load);
    case PositionerKind::kArm:
      break;
  }
  return Arm(load);
}

std::vector<std::string> KeysOf(PositionerKind kind) {
  std::vector<std::string> keys = {"kind", "carries"};
  if (kind != PositionerKind::kArm) keys.emplace_back("axes");
  for (const SigmaKey& key : kSigmas) {
    if (key.kind == kind) keys.emplace_back(key.name);
  }
  if (kind == PositionerKind::kGantry) keys.emplace_back(kAxisScale);
  return keys;
}

Result<void> ReadSigmas(const toml::table& table, const std::string& file, RigFile& rig) {
  for (const SigmaKey& key : kSigmas) {
    const toml::node* node = table.get(key.name);
    if (key.kind != rig.model.positioner.kind || node == nullptr) continue;
    const Result<double> value = TomlNumber(*node, KeyPlace(file, *node, key.name), key.range);
    if (!value) return Fail(value.error());
    const bool gantry = key.kind == PositionerKind::kGantry;
    const int count = gantry ? static_cast<int>(rig.axes.size()) : key.count;
    rig.model.error_sigma.segment(key.first, count).setConstant(*value * key.to_si);
  }
  const toml::node* scale = table.get(kAxisScale);
  if (scale == nullptr) return {};
  const Result<double> value = TomlNumber(*scale, KeyPlace(file, *scale, kAxisScale), {0, kMaxScaleSigma});
  if (!value) return Fail(value.error());
  rig.model.axis_scale_sigma = *value;
  return {};
}

Result<double> AxisValue(const RecordedStop& stop, const std::string& axis, AxisUnit unit,
                         const std::string& recording_name) {
  const auto at = std::ranges::find(stop.axes, axis, &AxisPosition::axis);
  if (at == stop.axes.end()) {
    return Fail(ErrorCode::kBadInput, "{}: stop '{}' has no position of the axis '{}' of the rig", recording_name,
                stop.id, axis);
  }
  if (at->unit != unit) {
    return Fail(ErrorCode::kBadInput, "{}: stop '{}': the axis '{}' is in {}, the rig's is in {}", recording_name,
                stop.id, axis, at->unit == AxisUnit::kRadian ? "radians" : "metres",
                unit == AxisUnit::kRadian ? "radians" : "metres");
  }
  return at->reported.value_or(at->commanded);
}

}  // namespace

Result<RigFile> ParseRig(std::string_view text, const std::string& file) {
  const Result<toml::table> document = ParseToml(text, file);
  if (!document) return Fail(document.error());
  if (auto known = CheckKeys(*document, file, "a rig file", {"positioner"}); !known) return Fail(known.error());
  const toml::table* table = (*document)["positioner"].as_table();
  if (table == nullptr) return Fail(ErrorCode::kBadInput, "{}: the table [positioner] is missing", file);

  const auto kind = WordFrom<PositionerKind>(*table, "kind", file, kPositionerKinds, {});
  if (!kind) return Fail(kind.error());
  const std::string what = fmt::format("a positioner of this kind ({})", table->get("kind")->ref<std::string>());
  if (auto known = CheckKeys(*table, file, what, KeysOf(*kind)); !known) return Fail(known.error());
  const bool turntable = *kind == PositionerKind::kTurntable;
  const auto load = WordFrom<PositionerLoad>(*table, "carries", file, kPositionerLoads,
                                             turntable ? std::optional(PositionerLoad::kObject) : std::nullopt);
  if (!load) return Fail(load.error());
  if (turntable && *load != PositionerLoad::kObject) {
    return Fail(ErrorCode::kBadInput, "{} = \"cameras\": a turntable carries the object",
                KeyPlace(file, *table->get("carries"), "carries"));
  }
  Result<std::vector<std::string>> axes = AxesFrom(*table, file, *kind);
  if (!axes) return Fail(axes.error());
  RigFile rig{ModelOf(*kind, *load, static_cast<int>(axes->size())), std::move(*axes)};
  if (auto read = ReadSigmas(*table, file, rig); !read) return Fail(read.error());
  return rig;
}

std::string RigText(const RigFile& rig) {
  const Positioner& positioner = rig.model.positioner;
  std::string text = fmt::format("[positioner]\nkind = \"{}\"\ncarries = \"{}\"\n",
                                 WordOf(kPositionerKinds, positioner.kind), WordOf(kPositionerLoads, positioner.load));
  if (!rig.axes.empty()) text += fmt::format("axes = [\"{}\"]\n", Joined(rig.axes, "\", \""));
  for (const SigmaKey& key : kSigmas) {
    if (key.kind != positioner.kind) continue;
    text += fmt::format("{} = {:.12g}\n", key.name, rig.model.error_sigma[key.first] / key.to_si);
  }
  if (positioner.kind == PositionerKind::kGantry) {
    text += fmt::format("{} = {:.12g}\n", kAxisScale, rig.model.axis_scale_sigma);
  }
  return text;
}

Result<std::vector<StopPosition>> StopPositions(const Recording& recording, const RigFile& rig,
                                                const std::string& recording_name) {
  const PositionerKind kind = rig.model.positioner.kind;
  const AxisUnit unit = kind == PositionerKind::kTurntable ? AxisUnit::kRadian : AxisUnit::kMetre;
  std::vector<StopPosition> positions;
  for (const RecordedStop& stop : recording.stops) {
    StopPosition position{.id = stop.id};
    for (const std::string& axis : rig.axes) {
      const Result<double> value = AxisValue(stop, axis, unit, recording_name);
      if (!value) return Fail(value.error());
      position.axes.push_back(*value);
    }
    if (kind == PositionerKind::kArm) {
      position.base_from_flange =
          stop.base_from_flange_reported ? stop.base_from_flange_reported : stop.base_from_flange_commanded;
      if (!position.base_from_flange) {
        return Fail(ErrorCode::kBadInput, "{}: stop '{}' has no pose of the arm's flange", recording_name, stop.id);
      }
    }
    positions.push_back(std::move(position));
  }
  return positions;
}

}  // namespace rigcal
