#include "config/calibration_store.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "config/calibration_file.h"
#include "config/json_text.h"
#include "config/run_report.h"
#include "core/base/joined.h"

namespace rigcal {
namespace {

constexpr std::size_t kMaxRigName = 64;  // fits a file name, a metric's label and a line of a table

bool IsRigName(const std::string& name) {
  constexpr std::string_view kAllowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
  return !name.empty() && name.size() <= kMaxRigName && name.find_first_not_of(kAllowed) == std::string::npos;
}

std::string Named(const std::optional<int>& revision) {
  return revision ? fmt::format("revision {}", *revision) : "no revision";
}

Result<void> CheckExpected(const PublishRequest& request, const std::vector<PublishEvent>& events) {
  const PublishEvent* last = events.empty() ? nullptr : &events.back();
  const std::optional<int> in_force = last != nullptr ? std::optional(last->revision) : std::nullopt;
  if (in_force == request.expected) return {};
  const std::string expected = request.expected ? std::to_string(*request.expected) : "none";
  if (last == nullptr) {
    return Fail(ErrorCode::kConflict, "rig '{}': no revision is in force, not {} as expected", request.rig, expected);
  }
  return Fail(ErrorCode::kConflict, "rig '{}': revision {} is in force, not {} as expected: published by {} at {}",
              request.rig, last->revision, expected, last->by, last->time);
}

/// The chain of one rig's events: each begins where the one before ended.
void CheckChain(const RigHistory& history, std::vector<std::string>& findings) {
  std::optional<int> in_force;
  for (const PublishEvent& event : history.events) {
    if (event.previous != in_force) {
      findings.push_back(fmt::format("rig '{}': publish event {} says that {} was in force before, it was {}",
                                     event.rig, event.number, Named(event.previous), Named(in_force)));
    }
    if (std::ranges::find(history.revisions, event.revision, &RevisionHead::number) == history.revisions.end()) {
      findings.push_back(fmt::format("rig '{}': publish event {} names revision {}, which is not there", event.rig,
                                     event.number, event.revision));
    }
    in_force = event.revision;
  }
}

}  // namespace

Result<void> CheckRevision(const CalibrationRevision& revision) {
  const RevisionHead& head = revision.head;
  if (!IsRigName(head.rig)) {
    return Fail(ErrorCode::kBadInput, "'{}' names no rig: 1 to {} letters, digits, '.', '_' and '-' are needed",
                head.rig, kMaxRigName);
  }
  const auto calibration = ParseCalibration(revision.calibration_text, "calibration of the revision");
  if (!calibration) return Fail(calibration.error());
  if (!nlohmann::json::accept(revision.report_text)) {
    return Fail(ErrorCode::kBadInput, "report of the revision: is not JSON");
  }
  if ((head.verdict == Verdict::kAccepted) != head.reasons.empty()) {
    return Fail(ErrorCode::kBadInput, "a revision for rig '{}' is {} with {} reasons; accepted means none", head.rig,
                NameOf(head.verdict), head.reasons.size());
  }
  return {};
}

Result<void> CheckPublish(const PublishRequest& request, const RevisionHead& revision,
                          const std::vector<PublishEvent>& events) {
  if (request.by.empty() || !IsUtf8(request.by) || !IsUtf8(request.reason)) {
    return Fail(ErrorCode::kBadInput, "rig '{}': who publishes and the reason must be UTF-8, and who not empty",
                request.rig);
  }
  if (auto checked = CheckExpected(request, events); !checked) return checked;
  if (!events.empty() && events.back().revision == request.revision) {
    return Fail(ErrorCode::kConflict, "rig '{}': revision {} is in force already: published by {} at {}", request.rig,
                request.revision, events.back().by, events.back().time);
  }
  const bool was_in_force = std::ranges::find(events, request.revision, &PublishEvent::revision) != events.end();
  if (request.kind == PublishKind::kRollback && !was_in_force) {
    return Fail(ErrorCode::kBadInput, "rig '{}': revision {} was never in force, so nothing rolls back to it",
                request.rig, request.revision);
  }
  if (request.kind == PublishKind::kPublish && revision.verdict != Verdict::kAccepted && request.reason.empty()) {
    return Fail(ErrorCode::kBadInput, "rig '{}': revision {} is {} ({}); a person may publish it with a reason",
                request.rig, request.revision, NameOf(revision.verdict), Joined(revision.reasons, "; "));
  }
  return {};
}

std::optional<int> RevisionBefore(const std::vector<PublishEvent>& events) {
  std::vector<int> steps;  // what was published for good, as far as it was not rolled back
  for (const PublishEvent& event : events) {
    if (event.kind == PublishKind::kRollback) {
      const auto back_to = std::ranges::find(steps.rbegin(), steps.rend(), event.revision);
      if (back_to != steps.rend()) {
        steps.erase(back_to.base(), steps.end());
        continue;
      }
    }
    steps.push_back(event.revision);
  }
  if (steps.size() < 2) return std::nullopt;
  return steps[steps.size() - 2];
}

Result<std::vector<std::string>> CheckContent(CalibrationStore& store, const std::stop_token& stop) {
  std::vector<std::string> findings;
  const auto rigs = store.Rigs();
  if (!rigs) return Fail(rigs.error());
  for (const std::string& rig : *rigs) {
    const auto history = store.History(rig);
    if (!history) return Fail(history.error());
    for (const RevisionHead& head : history->revisions) {
      if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "checking the store was stopped");
      const auto revision = store.Load(rig, head.number);
      const auto checked = revision ? CheckRevision(*revision) : Result<void>(Fail(revision.error()));
      if (!checked) findings.push_back(fmt::format("revision {}: {}", head.number, checked.error().message));
    }
    CheckChain(*history, findings);
  }
  return findings;
}

Result<std::set<std::string>> RecordingsOfRevisions(CalibrationStore& store) {
  std::set<std::string> recordings;
  const auto rigs = store.Rigs();
  if (!rigs) return Fail(rigs.error());
  for (const std::string& rig : *rigs) {
    const auto history = store.History(rig);
    if (!history) return Fail(history.error());
    for (const RevisionHead& head : history->revisions) {
      for (const std::string& known : {head.origin.recording_id, head.origin.recording_sha256}) {
        if (!known.empty()) recordings.insert(known);
      }
    }
  }
  return recordings;
}

const char* NameOf(PublishKind kind) {
  return kind == PublishKind::kPublish ? "publish" : "rollback";
}

}  // namespace rigcal
