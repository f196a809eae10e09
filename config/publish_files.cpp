#include "config/publish_files.h"

#include <algorithm>

#include "config/calibration_file.h"
#include "config/json_text.h"
#include "config/read_file.h"
#include "config/run_report.h"
#include "config/staged_files.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

std::string NameOfRevision(const CalibrationRevision& revision) {
  return fmt::format("revision {} of rig '{}'", revision.head.number, revision.head.rig);
}

/// Whoever reads the folder would take the cameras of one rig for those of another.
Result<void> CheckRig(const std::string& rig, const std::filesystem::path& current_file) {
  const Result<std::string> text = ReadFile(current_file);
  const Json json = text ? Json::parse(*text, nullptr, false) : Json();
  const Json::json_pointer place("/revision/rig");
  if (!json.is_object() || !json.contains(place) || json[place] == rig) return {};
  return Fail(ErrorCode::kBadInput, "{}: is that of the rig {}, not of '{}'; a rig needs a folder of its own",
              current_file.string(), json[place].dump(-1, ' ', false, Json::error_handler_t::replace), rig);
}

/// Writes the formats of the revision, hidden, into the locked folder.
Result<std::vector<std::string>> Stage(const CalibrationRevision& revision, const PublishFolder& target,
                                       StagedFiles& staged) {
  if (auto free = CheckRig(revision.head.rig, target.folder / kCurrentFile); !free) return Fail(free.error());
  const auto content = ParseCalibration(revision.calibration_text, NameOfRevision(revision));
  if (!content) return Fail(content.error());
  return staged.Write(content->calibration, target.formats);
}

Result<void> Show(const CalibrationRevision& revision, const PublishEvent& event, const PublishFolder& target,
                  StagedFiles& staged) {
  const Result<std::string> current = CurrentText(revision, event, target.formats);
  if (!current) return Fail(current.error());
  return staged.Show(*current);
}

bool IsShown(const std::string& current_text, const PublishFolder& target) {
  const Result<std::string> shown = ReadFile(target.folder / kCurrentFile);
  if (!shown || *shown != current_text) return false;
  return std::ranges::all_of(target.formats, [&](const PublishedFormat& format) {
    std::error_code error;  // a link that leads nowhere does not exist
    return std::filesystem::exists(target.folder / PublishedName(format.format), error);
  });
}

}  // namespace

Result<std::string> CurrentText(const CalibrationRevision& revision, const PublishEvent& event,
                                const std::vector<PublishedFormat>& formats) {
  const std::string name = NameOfRevision(revision);
  if (const auto content = ParseCalibration(revision.calibration_text, name); !content) return Fail(content.error());
  Json json = Json::parse(revision.calibration_text);
  Json files = Json::array();
  for (const PublishedFormat& format : formats) {
    files.push_back(
        {{"name", PublishedName(format.format)}, {"format", format.format}, {"undistorted", format.undistorted}});
  }
  json["revision"] = {
      {"rig", revision.head.rig},      {"number", revision.head.number}, {"verdict", NameOf(revision.head.verdict)},
      {"made_at", revision.head.time}, {"published_at", event.time},     {"published_by", event.by},
      {"kind", NameOf(event.kind)},    {"reason", event.reason},         {"files", std::move(files)}};
  return JsonText(json);
}

Result<Published> PublishRevision(CalibrationStore& store, const PublishRequest& request, const PublishFolder& target,
                                  Clock& clock, const std::stop_token& stop) {
  const auto revision = store.Load(request.rig, request.revision);
  if (!revision) return Fail(revision.error());
  StagedFiles staged(target.folder);
  if (auto locked = staged.Lock(clock, stop); !locked) return Fail(locked.error());
  auto notes = Stage(*revision, target, staged);
  if (!notes) return Fail(notes.error());
  const auto event = store.Publish(request);
  if (!event) return Fail(event.error());
  if (auto shown = Show(*revision, *event, target, staged); !shown) {
    return Fail(shown.error().code, "{} is in force, but its files are not all written: {}", NameOfRevision(*revision),
                shown.error().message);
  }
  return Published{*event, std::move(*notes)};
}

Result<bool> RepairPublished(CalibrationStore& store, const std::string& rig, const PublishFolder& target, Clock& clock,
                             const std::stop_token& stop) {
  StagedFiles staged(target.folder);
  if (auto locked = staged.Lock(clock, stop); !locked) return Fail(locked.error());
  const auto event = store.InForce(rig);
  if (!event) return Fail(event.error());
  if (!*event) return false;
  const auto revision = store.Load(rig, (*event)->revision);
  if (!revision) return Fail(revision.error());
  const auto current = CurrentText(*revision, **event, target.formats);
  if (!current) return Fail(current.error());
  if (IsShown(*current, target)) return false;
  if (const auto notes = Stage(*revision, target, staged); !notes) return Fail(notes.error());
  if (auto shown = Show(*revision, **event, target, staged); !shown) return Fail(shown.error());
  return true;
}

}  // namespace rigcal
