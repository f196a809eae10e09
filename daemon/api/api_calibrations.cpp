#include <algorithm>

#include "daemon/api/api.h"
#include "daemon/api/request_content.h"
#include "daemon/store_diff.h"
#include "daemon/store_report.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char *kContentCalibration = "calibration", *kContentReport = "report";

/// A revision of the query, as in ?before=3.
Result<int> RevisionIn(const ApiRequest& request, const char* key) {
  const auto found = request.query.find(key);
  if (found == request.query.end()) return Fail(ErrorCode::kBadInput, "?{}= with a revision is missing", key);
  return NumberFrom(found->second, "revision");
}

/// The revision under a key of the body; nothing for null.
Result<std::optional<int>> RevisionUnder(const nlohmann::json& body, const char* key) {
  const auto found = body.find(key);
  if (found == body.end() || found->is_null()) return std::optional<int>();
  if (found->is_number_integer() && found->get<double>() >= 1 && found->get<double>() <= INT32_MAX) {
    return std::optional(found->get<int>());
  }
  return Fail(ErrorCode::kBadInput, "'{}' must be the number of a revision, or null", key);
}

}  // namespace

ApiReply Api::ListCalibrations(const ApiRequest& /*request*/, const Parts& /*parts*/) {
  const std::lock_guard lock(store_mutex_);
  const auto history = world_.store.History(world_.station()->name);
  if (!history) return ErrorReply(history.error());
  return {.body = HistoryJson(*history), .events = {}};
}

ApiReply Api::ShowCalibration(const ApiRequest& request, const Parts& parts) {
  const Result<int> number = NumberFrom(parts[0], "revision");
  if (!number) return ErrorReply(number.error());
  const std::lock_guard lock(store_mutex_);
  const std::string& rig = world_.station()->name;
  const auto revision = world_.store.Load(rig, *number);
  if (!revision) return ErrorReply(revision.error());
  const auto content = request.query.find("content");
  if (content == request.query.end()) {
    const auto history = world_.store.History(rig);
    if (!history) return ErrorReply(history.error());
    return {.body = RevisionJson(revision->head, history->events), .events = {}};
  }
  if (content->second == kContentCalibration) return {.body = revision->calibration_text, .events = {}};
  if (content->second == kContentReport) return {.body = revision->report_text, .events = {}};
  return ErrorReply({ErrorCode::kBadInput, "?content= must be 'calibration' or 'report'"});
}

ApiReply Api::DiffCalibrations(const ApiRequest& request, const Parts& /*parts*/) {
  const Result<int> before = RevisionIn(request, "before"), after = RevisionIn(request, "after");
  if (!before) return ErrorReply(before.error());
  if (!after) return ErrorReply(after.error());
  const std::lock_guard lock(store_mutex_);
  const auto diff = DiffRevisions(world_.store, world_.station()->name, *before, *after);
  if (!diff) return ErrorReply(diff.error());
  return {.body = DiffJson(*diff), .events = {}};
}

Result<PublishRequest> Api::ReadPublish(const ApiRequest& request, PublishKind kind,
                                        const std::optional<int>& revision) {
  std::vector<std::string_view> keys = {"expected", "by", "reason"};
  if (!revision) keys.emplace_back("revision");
  const auto body = ObjectFrom(request.body, keys);
  if (!body) return Fail(body.error());
  const auto by = TextUnder(*body, "by", "a client", limits_.max_name);
  if (!by) return Fail(by.error());
  const auto reason = TextUnder(*body, "reason", "", limits_.max_reason);
  if (!reason) return Fail(reason.error());
  const auto expected = RevisionUnder(*body, "expected"), wanted = RevisionUnder(*body, "revision");
  if (!expected) return Fail(expected.error());
  if (!wanted) return Fail(wanted.error());
  PublishRequest wish{
      .rig = world_.station()->name, .kind = kind, .time = world_.now_text(), .by = *by, .reason = *reason};
  const auto history = world_.store.History(wish.rig);
  if (!history) return Fail(history.error());
  wish.expected = *expected;
  if (!body->contains("expected") && !history->events.empty()) wish.expected = history->events.back().revision;
  const std::optional<int> target = revision ? revision : *wanted ? *wanted : RevisionBefore(history->events);
  if (!target) {
    return Fail(ErrorCode::kBadInput, "rig '{}': there is no earlier publication to roll back to", wish.rig);
  }
  wish.revision = *target;
  return wish;
}

ApiReply Api::MovePointer(const PublishRequest& wish) {
  const auto published = PublishRevision(world_.store, wish, world_.station()->publish, world_.clock, {});
  if (!published) return ErrorReply(published.error());
  const PublishEvent& event = published->event;
  return {.body = ReplyText({{"revision", event.revision},
                             {"previous", event.previous ? Json(*event.previous) : Json(nullptr)},
                             {"kind", NameOf(event.kind)},
                             {"time", event.time},
                             {"by", event.by},
                             {"reason", event.reason},
                             {"notes", published->notes}}),
          .events = {}};
}

ApiReply Api::Publish(const ApiRequest& request, const Parts& parts) {
  const Result<int> number = NumberFrom(parts[0], "revision");
  if (!number) return ErrorReply(number.error());
  const std::lock_guard lock(store_mutex_);
  const auto wish = ReadPublish(request, PublishKind::kPublish, *number);
  return wish ? MovePointer(*wish) : ErrorReply(wish.error());
}

ApiReply Api::Rollback(const ApiRequest& request, const Parts& /*parts*/) {
  const std::lock_guard lock(store_mutex_);
  const auto wish = ReadPublish(request, PublishKind::kRollback, std::nullopt);
  return wish ? MovePointer(*wish) : ErrorReply(wish.error());
}

}  // namespace rigcal
