#include <memory>

#include "daemon/api/api.h"
#include "daemon/api/job_json.h"
#include "daemon/api/request_content.h"
#include "daemon/jobs/job_kinds.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kListedByDefault = 20;
constexpr const char* kUnknownClient = "a client";

ApiReply JobReply(const Result<JobStatus>& status, int code) {
  if (!status) return ErrorReply(status.error());
  return {.status = code, .body = ReplyText(JobJson(*status)), .events = {}};
}

std::string EventText(const JobStatus& status) {
  return fmt::format("id: {}\nevent: job\ndata: {}\n\n", status.sequence,
                     JobJson(status).dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

ApiReply Api::ListJobs(const ApiRequest& request, const Parts& /*parts*/) {
  int count = kListedByDefault;
  if (const auto given = request.query.find("count"); given != request.query.end()) {
    const Result<int> number = NumberFrom(given->second, "count");
    if (!number) return ErrorReply(number.error());
    count = std::min(*number, limits_.max_listed_jobs);
  }
  const auto jobs = world_.queue.Newest(count);
  if (!jobs) return ErrorReply(jobs.error());
  Json list = Json::array();
  for (const JobStatus& status : *jobs) list.push_back(JobJson(status));
  return {.body = ReplyText({{"jobs", std::move(list)}}), .events = {}};
}

ApiReply Api::ShowJob(const ApiRequest& /*request*/, const Parts& parts) {
  const Result<int> id = NumberFrom(parts[0], "job");
  return id ? JobReply(world_.queue.Find(*id), kStatusOk) : ErrorReply(id.error());
}

ApiReply Api::SubmitJob(const ApiRequest& request, const Parts& /*parts*/) {
  const auto body = ObjectFrom(request.body, {"kind", "request", "by"});
  if (!body) return ErrorReply(body.error());
  const auto name = TextUnder(*body, "kind", "", limits_.max_name);
  if (!name) return ErrorReply(name.error());
  const auto by = TextUnder(*body, "by", kUnknownClient, limits_.max_name);
  if (!by) return ErrorReply(by.error());
  const JobKind* kind = FindJobKind(*name);
  if (kind == nullptr) {
    std::string known;
    for (const JobKind& row : JobKinds()) known += (known.empty() ? "" : ", ") + std::string(row.name);
    return ErrorReply({ErrorCode::kBadInput, fmt::format("'{}' is no kind of job, those are {}", *name, known)});
  }
  const nlohmann::json wish = body->value("request", nlohmann::json::object());
  if (const auto checked = CheckJobRequest(*kind, wish); !checked) return ErrorReply(checked.error());
  const Result<Job> job = world_.queue.Submit(*name, wish.dump(), by->empty() ? kUnknownClient : *by);
  if (!job) return ErrorReply(job.error());
  return JobReply(world_.queue.Find(job->id), kStatusAccepted);
}

ApiReply Api::CancelJob(const ApiRequest& request, const Parts& parts) {
  const Result<int> id = NumberFrom(parts[0], "job");
  if (!id) return ErrorReply(id.error());
  if (const auto body = ObjectFrom(request.body, {}); !body) return ErrorReply(body.error());
  return JobReply(world_.queue.Cancel(*id), kStatusAccepted);
}

ApiReply Api::JobEvents(const ApiRequest& /*request*/, const Parts& parts) {
  const Result<int> id = NumberFrom(parts[0], "job");
  if (!id) return ErrorReply(id.error());
  if (const auto status = world_.queue.Find(*id); !status) return ErrorReply(status.error());
  if (num_streams_.fetch_add(1) >= limits_.max_event_streams) {
    --num_streams_;
    return ErrorReply(kStatusUnavailable, "too_many_streams",
                      fmt::format("{} clients follow jobs already, no more may", limits_.max_event_streams));
  }
  const std::shared_ptr<void> counted(nullptr, [this](void*) { --num_streams_; });
  struct Follower {
    std::uint64_t seen = 0;
    bool first = true, over = false;
  };
  auto follower = std::make_shared<Follower>();
  EventStream events{[this, counted, follower, id = *id]() -> std::optional<std::string> {
    if (follower->over) return std::nullopt;
    const double wait_s = follower->first ? 0 : limits_.event_wait_s;
    const auto status = world_.queue.WaitForChange(id, follower->seen, wait_s, {});
    if (!status) return std::nullopt;
    const bool changed = follower->first || status->sequence > follower->seen;
    follower->first = false;
    follower->seen = status->sequence;
    follower->over = HasEnded(status->job.state);
    return changed || follower->over ? EventText(*status) : ": still here\n\n";
  }};
  return {.type = "text/event-stream", .body = {}, .events = std::move(events)};
}

}  // namespace rigcal
