#include "daemon/store_report.h"

#include <fmt/format.h>

#include "config/json_text.h"
#include "config/provenance_json.h"
#include "config/run_report.h"
#include "core/base/joined.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

Json NumberOrNull(const std::optional<int>& number) {
  return number ? Json(*number) : Json(nullptr);
}

std::string Known(const std::string& text) {
  return text.empty() ? "not known" : text;
}

std::string Known(const std::optional<int>& revision) {
  return revision ? fmt::format("revision {}", *revision) : "none";
}

Json HeadJson(const RevisionHead& head) {
  const RevisionOrigin& origin = head.origin;
  return {{"number", head.number},
          {"rig", head.rig},
          {"time", head.time},
          {"verdict", NameOf(head.verdict)},
          {"reasons", head.reasons},
          {"parent", NumberOrNull(head.parent)},
          {"seed_revision", NumberOrNull(origin.seed_revision)},
          {"recording", {{"id", origin.recording_id}, {"sha256", origin.recording_sha256}}},
          {"calibration_sha256", head.calibration_sha256},
          {"provenance", ProvenanceJson(origin.run)}};
}

Json EventJson(const PublishEvent& event) {
  return {{"number", event.number},
          {"time", event.time},
          {"kind", NameOf(event.kind)},
          {"revision", event.revision},
          {"previous", NumberOrNull(event.previous)},
          {"by", event.by},
          {"reason", event.reason}};
}

std::string OptionsText(const Provenance& run) {
  std::vector<std::string> options;
  for (const auto& [name, value] : run.options) {
    if (!value.empty()) options.push_back(fmt::format("{}={}", name, value));
  }
  return options.empty() ? "none" : Joined(options, " ");
}

}  // namespace

std::string EventText(const PublishEvent& event) {
  std::string text = fmt::format("{}  {} {} -> {} by {}", event.time, NameOf(event.kind),
                                 event.previous ? std::to_string(*event.previous) : "none", event.revision, event.by);
  if (!event.reason.empty()) text += ": " + event.reason;
  return text;
}

std::string HistoryText(const RigHistory& history) {
  const int in_force = history.events.empty() ? 0 : history.events.back().revision;
  std::string text;
  for (const RevisionHead& head : history.revisions) {
    text += fmt::format("{} {:>5}  {}  {:12} {}\n", head.number == in_force ? '*' : ' ', head.number, head.time,
                        NameOf(head.verdict), head.reasons.empty() ? "" : head.reasons.front());
  }
  for (const PublishEvent& event : history.events) text += EventText(event) + "\n";
  return text;
}

std::string HistoryJson(const RigHistory& history) {
  Json json = {{"in_force", history.events.empty() ? Json(nullptr) : Json(history.events.back().revision)}};
  json["revisions"] = Json::array();
  for (const RevisionHead& head : history.revisions) json["revisions"].push_back(HeadJson(head));
  json["events"] = Json::array();
  for (const PublishEvent& event : history.events) json["events"].push_back(EventJson(event));
  return JsonText(json);
}

std::string RevisionText(const RevisionHead& head, const std::vector<PublishEvent>& events) {
  const RevisionOrigin& origin = head.origin;
  std::string text =
      fmt::format("revision {} of rig '{}', made {}: {}\n", head.number, head.rig, head.time, NameOf(head.verdict));
  for (const std::string& reason : head.reasons) text += "  " + reason + "\n";
  text += fmt::format("in force when it was stored: {}\nseed: {}\n", Known(head.parent), Known(origin.seed_revision));
  text += fmt::format("recording: {}, SHA-256 {}\n", Known(origin.recording_id), Known(origin.recording_sha256));
  text += fmt::format("made by: rigcal {}, method {}, random seed {}\noptions: {}\n", origin.run.program_version,
                      origin.run.method, origin.run.random_seed, OptionsText(origin.run));
  text += fmt::format("inputs: {} files, their SHA-256 with --json\ncalibration: SHA-256 {}\n",
                      origin.run.inputs.size(), head.calibration_sha256);
  for (const PublishEvent& event : events) {
    if (event.revision == head.number) text += EventText(event) + "\n";
  }
  if (!events.empty() && events.back().revision == head.number) text += "in force\n";
  return text;
}

std::string RevisionJson(const RevisionHead& head, const std::vector<PublishEvent>& events) {
  Json json = HeadJson(head);
  json["in_force"] = !events.empty() && events.back().revision == head.number;
  json["events"] = Json::array();
  for (const PublishEvent& event : events) {
    if (event.revision == head.number) json["events"].push_back(EventJson(event));
  }
  return JsonText(json);
}

}  // namespace rigcal
