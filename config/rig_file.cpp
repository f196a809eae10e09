#include "config/rig_file.h"

#include <algorithm>
#include <array>
#include <map>

#include "config/export.h"
#include "config/positioner_names.h"
#include "config/read_file.h"
#include "config/rig_hardware.h"
#include "config/rig_stops.h"
#include "core/base/joined.h"

namespace rigcal {
namespace {

/// Which components of a StopError a key of [positioner] gives the size of.
struct SigmaKey {
  std::string_view name;
  PositionerKind kind;
  int first, count;
};
constexpr std::array<SigmaKey, 7> kSigmas = {{
    {"step_sigma_deg", PositionerKind::kTurntable, kStep, 1},
    {"wobble_sigma_deg", PositionerKind::kTurntable, kWobbleX, 2},
    {"run_out_sigma_m", PositionerKind::kTurntable, kRunOutX, 2},
    {"lift_sigma_m", PositionerKind::kTurntable, kLift, 1},
    {"position_sigma_m", PositionerKind::kGantry, 3, 3},
    {"position_sigma_m", PositionerKind::kArm, 3, 3},
    {"rotation_sigma_deg", PositionerKind::kArm, 0, 3},
}};
constexpr std::string_view kPositioner = "positioner", kAxisScale = "axis_scale_sigma";

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

void ReadSigmas(const CheckedTable& table, RigFile& rig) {
  for (const SigmaKey& key : kSigmas) {
    if (key.kind != rig.model.positioner.kind || !table.Has(key.name)) continue;
    double sigma = 0;
    table.Read(key.name, sigma);
    const bool gantry = key.kind == PositionerKind::kGantry;
    const int count = gantry ? static_cast<int>(rig.axes.size()) : key.count;
    rig.model.error_sigma.segment(key.first, count).setConstant(sigma);
  }
  if (rig.model.positioner.kind == PositionerKind::kGantry) table.Read(kAxisScale, rig.model.axis_scale_sigma);
}

/// Its word, from which the keys of the other tables follow.
Result<std::string> KindFrom(const toml::table& positioner, const std::string& file) {
  const RigKey& key = *RigTableNamed(kPositioner).Find("kind", "");
  const toml::node* node = positioner.get(key.name);
  if (node == nullptr)
    return Fail(ErrorCode::kBadInput, "{}: positioner.kind is missing, {}", file, KeyDescription(key));
  if (auto checked = CheckRigValue(*node, key, file); !checked) return Fail(checked.error());
  return node->ref<std::string>();
}

Result<PositionerLoad> LoadFrom(const CheckedTable& table, PositionerKind kind) {
  std::string carries(WordOf(kPositionerLoads, PositionerLoad::kObject));
  table.Read("carries", carries);
  const PositionerLoad load = *FromWord(kPositionerLoads, carries);
  if (kind == PositionerKind::kTurntable && load != PositionerLoad::kObject)
    return Fail(ErrorCode::kBadInput, "{} = \"{}\": a turntable carries the object", table.Place("carries"), carries);
  return load;
}

Result<PublishSettings> ReadPublish(const CheckedTable& table, const std::string& file) {
  PublishSettings publish;
  std::string folder;
  table.Read("rig", publish.rig);
  table.Read("folder", folder);
  if (!folder.empty()) publish.folder = BesideRigFile(file, folder);
  table.Read("formats", publish.formats);
  table.Read("undistorted", publish.undistorted);
  for (const std::string& format : publish.formats) {
    if (ExportFormatFromName(format)) continue;
    return Fail(ErrorCode::kBadInput, "{}: '{}' is no format of `rigcal export`", table.Place("formats"), format);
  }
  return publish;
}

/// Every table but [positioner].
Result<void> ReadOtherTables(const toml::table& document, const std::string& file, const std::string& kind,
                             RigFile& rig) {
  std::map<std::string_view, std::optional<CheckedTable>> tables;
  for (const std::string_view name : {"stops", "capture", "keep", "publish", "drift", "chart", "replay", "sim"}) {
    auto table = CheckedSection(document, name, file, kind);
    if (!table) return Fail(table.error());
    tables.emplace(name, std::move(*table));
  }
  rig.capture = ReadCapture(tables["capture"]);
  rig.keep = ReadKeep(tables["keep"]);
  if (const auto& drift = tables["drift"]) drift->Read("limit_px", rig.drift.limit_px);
  if (const auto& chart = tables["chart"]) {
    std::string board;
    chart->Read("board", board);
    rig.board = BesideRigFile(file, board);
  }
  if (const auto& table = tables["publish"]) {
    auto publish = ReadPublish(*table, file);
    if (!publish) return Fail(publish.error());
    rig.publish = std::move(*publish);
  }
  if (const auto& stops = tables["stops"]) {
    auto read = ReadStops(*stops, rig.positioner.axes);
    if (!read) return Fail(read.error());
    rig.capture.stops = std::move(*read);
  }
  const auto camera_tables = CheckedSections(document.get("camera"), "camera", file, kind);
  if (!camera_tables) return Fail(camera_tables.error());
  auto cameras = ReadCameras(*camera_tables, rig.capture.picture_s);
  if (!cameras) return Fail(cameras.error());
  rig.cameras = std::move(*cameras);
  auto sim = ReadSim(tables["sim"], rig.positioner, rig.cameras);
  if (!sim) return Fail(sim.error());
  rig.sim = std::move(*sim);
  auto replay = ReadReplay(tables["replay"], file, rig.positioner, rig.cameras);
  if (!replay) return Fail(replay.error());
  rig.replay = std::move(*replay);
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
  if (auto known = CheckRigTables(*document, file); !known) return Fail(known.error());
  const toml::table* positioner = (*document)[kPositioner].as_table();
  if (positioner == nullptr) return Fail(ErrorCode::kBadInput, "{}: the table [positioner] is missing", file);
  const Result<std::string> word = KindFrom(*positioner, file);
  if (!word) return Fail(word.error());
  const PositionerKind kind = *FromWord(kPositionerKinds, *word);
  const auto table = CheckedTable::Check(*positioner, RigTableNamed(kPositioner), file, *word, {"axis"});
  if (!table) return Fail(table.error());
  const auto axes = CheckedSections(positioner->get("axis"), "positioner.axis", file, *word);
  if (!axes) return Fail(axes.error());
  const Result<PositionerLoad> load = LoadFrom(*table, kind);
  if (!load) return Fail(load.error());

  Result<PositionerSettings> device = ReadPositionerDevice(*table, *axes, kind);
  if (!device) return Fail(device.error());
  RigFile rig{.model = ModelOf(kind, *load, static_cast<int>(device->axes.size()))};
  for (const AxisSettings& axis : device->axes) rig.axes.push_back(axis.name);
  rig.positioner = std::move(*device);
  ReadSigmas(*table, rig);
  if (auto read = ReadOtherTables(*document, file, *word, rig); !read) return Fail(read.error());
  return rig;
}

Result<RigFile> LoadRig(const std::filesystem::path& path) {
  const Result<std::string> text = ReadFile(path);
  if (!text) return Fail(text.error());
  return ParseRig(*text, path.string());
}

std::string RigText(const RigFile& rig) {
  const Positioner& positioner = rig.model.positioner;
  std::string text = fmt::format("[positioner]\nkind = \"{}\"\ncarries = \"{}\"\n",
                                 WordOf(kPositionerKinds, positioner.kind), WordOf(kPositionerLoads, positioner.load));
  if (!rig.axes.empty()) text += fmt::format("axes = [\"{}\"]\n", Joined(rig.axes, "\", \""));
  for (const SigmaKey& key : kSigmas) {
    if (key.kind != positioner.kind) continue;
    const KeyUnit& unit = RigTableNamed(kPositioner).Find(key.name, WordOf(kPositionerKinds, key.kind))->unit;
    text += fmt::format("{} = {:.12g}\n", key.name, rig.model.error_sigma[key.first] / unit.to_si);
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
