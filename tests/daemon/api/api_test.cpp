#include "daemon/api/api.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "config/read_file.h"
#include "config/store/sqlite_store.h"
#include "daemon/jobs/job_kinds.h"
#include "tests/config/example_revision.h"
#include "tests/daemon/jobs/scripted_jobs.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

/// The API of a station whose jobs are played by the test.
class ApiTest : public ::testing::Test {
 protected:
  ApiTest() {
    auto store = OpenSqliteStore(bench_.folder.Path() / kStoreFile, {.create = true});
    EXPECT_TRUE(store) << store.error().message;
    store_ = std::move(*store);
    auto station = std::make_shared<Station>();
    station->name = "studio";
    station->state = bench_.folder.Path();
    station->publish.folder = bench_.folder.Path() / "published";
    station_ = station;
    api_.emplace(
        ApiWorld{bench_.queue, *store_, bench_.clock, [this] { return station_; }, [] { return QueueBench::Now(); }},
        ApiLimits{.max_event_streams = 2, .event_wait_s = kHangS});
  }

  ApiReply Ask(const std::string& method, const std::string& path, const std::string& body = "",
               std::map<std::string, std::string> query = {}) {
    return api_->Answer({method, path, std::move(query), body});
  }
  Json Good(const ApiReply& reply, int status = kStatusOk) {
    EXPECT_EQ(reply.status, status) << reply.body;
    return Json::parse(reply.body, nullptr, false);
  }
  void ExpectRefused(const ApiReply& reply, int status, const std::string& code, const std::string& words) {
    EXPECT_EQ(reply.status, status) << reply.body;
    const Json json = Json::parse(reply.body, nullptr, false);
    ASSERT_TRUE(json.is_object() && json.contains("error")) << reply.body;
    EXPECT_EQ(json["error"]["code"], code);
    EXPECT_THAT(json["error"]["message"].get<std::string>(), HasSubstr(words));
  }
  int Store(int variant, Verdict verdict = Verdict::kAccepted) {
    return *store_->Append(ExampleRevision("studio", variant, verdict));
  }

  QueueBench bench_;
  std::unique_ptr<CalibrationStore> store_;
  std::shared_ptr<const Station> station_;
  std::optional<Api> api_;
};

TEST_F(ApiTest, RoutesAreThoseOfTheDocument) {
  const auto text = ReadFile(RIGCAL_OPENAPI);
  ASSERT_TRUE(text);
  std::set<std::string> documented, answered;
  const Json document = Json::parse(*text);
  for (const auto& [path, operations] : document["paths"].items()) {
    for (const auto& [method, operation] : operations.items()) documented.insert(method + " " + path);
  }
  for (const ApiRoute& route : Api::Routes()) {
    std::string method(route.method);
    std::ranges::transform(method, method.begin(), [](char c) { return static_cast<char>(std::tolower(c)); });
    answered.insert(method + " " + std::string(route.path));
  }
  EXPECT_EQ(answered, documented);
  std::vector<std::string> kinds;
  for (const JobKind& kind : JobKinds()) kinds.emplace_back(kind.name);
  EXPECT_EQ(document["components"]["schemas"]["JobWish"]["properties"]["kind"]["enum"], kinds);
  std::set<std::string> keys, documented_keys;
  for (const JobKind& kind : JobKinds()) {
    for (const RequestKey& key : kind.keys) keys.emplace(key.name);
  }
  for (const auto& [key, schema] : document["components"]["schemas"]["JobRequest"]["properties"].items()) {
    documented_keys.insert(key);
  }
  EXPECT_EQ(keys, documented_keys);
}

TEST_F(ApiTest, AJobIsAskedForAndShown) {
  const Json job = Good(Ask("POST", "/api/v1/jobs",
                            R"({"kind": "replay", "request": {"recording": "night", "rounds": 2}, "by": "anna"})"),
                        kStatusAccepted);
  EXPECT_EQ(job["state"], "queued");
  EXPECT_EQ(job["request"]["rounds"], 2);
  EXPECT_EQ(job["by"], "anna");
  EXPECT_TRUE(job["outcome"].is_null());
  EXPECT_EQ(Good(Ask("GET", "/api/v1/jobs/1"))["id"], 1);
  EXPECT_EQ(Good(Ask("GET", "/api/v1/jobs"))["jobs"].size(), 1U);
  EXPECT_EQ(Good(Ask("POST", "/api/v1/jobs/1/cancel"), kStatusAccepted)["state"], "cancelled");
  ExpectRefused(Ask("POST", "/api/v1/jobs/1/cancel"), kStatusConflict, "conflict", "has ended already: cancelled");
}

TEST_F(ApiTest, ABadJobIsRefusedByTheKeyThatIsWrong) {
  const auto refused = [&](const std::string& body, const std::string& words) {
    ExpectRefused(Ask("POST", "/api/v1/jobs", body), kStatusBadRequest, "bad_input", words);
  };
  refused("{", "no JSON");
  refused("[]", "must be an object");
  refused("\"\xff\"", "no JSON");
  refused(R"({"kind": "dance"})", "'dance' is no kind of job, those are capture");
  refused(R"({"kind": 7})", "'kind' must be a text");
  refused(R"({"kind": "capture", "when": 1})", "unknown key 'when'");
  refused(R"({"kind": "capture", "request": []})", "must be an object");
  refused(R"({"kind": "capture", "request": {"rounds": 2}})", "'rounds' is no key of its request");
  refused(R"({"kind": "capture", "request": {"what": "cat"}})", "'what' must be \"chart\"");
  refused(R"({"kind": "capture", "request": {"stops": [1, "a"]}})", "'stops' must be a list");
  refused(R"({"kind": "replay"})", "'recording' is missing");
  refused(R"({"kind": "replay", "request": {"recording": "a", "rounds": 2.5}})", "'rounds' must be a whole number");
  refused(R"({"kind": "replay", "request": {"recording": "a", "rounds": 21}})", "from 1 to 20");
  refused(R"({"kind": "replay", "request": {"recording": ""}})", "'recording' must be a text");
  EXPECT_EQ(bench_.queue.NumWaiting(), 0U);
}

TEST_F(ApiTest, UnknownPathsMethodsAndNumbersAreRefused) {
  ExpectRefused(Ask("GET", "/api/v1/nothing"), kStatusNotFound, "not_found", "/api/v1/nothing");
  ExpectRefused(Ask("GET", "/../etc/passwd"), kStatusNotFound, "not_found", "there is no");
  ExpectRefused(Ask("GET", ""), kStatusNotFound, "not_found", "there is no");
  ExpectRefused(Ask("DELETE", "/api/v1/jobs"), kStatusWrongMethod, "wrong_method", "does not answer DELETE");
  ExpectRefused(Ask("GET", "/api/v1/jobs/x"), kStatusBadRequest, "bad_input", "'x' is no job");
  ExpectRefused(Ask("GET", "/api/v1/jobs/99999999999999"), kStatusBadRequest, "bad_input", "is no job");
  ExpectRefused(Ask("GET", "/api/v1/jobs/7"), kStatusNotFound, "not_found", "has no job 7");
  ExpectRefused(Ask("GET", "/api/v1/calibrations/7"), kStatusNotFound, "not_found", "no revision 7");
  ExpectRefused(Ask("GET", "/api/v1/calibrations/diff"), kStatusBadRequest, "bad_input", "?before=");
}

TEST_F(ApiTest, PublishesAndRollsBackAndTellsWhoComesLate) {
  const int first = Store(1), second = Store(2), rejected = Store(3, Verdict::kRejected);
  const auto publish = [&](int revision, const std::string& body) {
    return Ask("POST", fmt::format("/api/v1/calibrations/{}/publish", revision), body);
  };
  EXPECT_EQ(Good(publish(first, R"({"expected": null, "by": "anna"})"))["revision"], first);
  EXPECT_TRUE(std::filesystem::exists(station_->publish.folder / kCurrentFile));
  ExpectRefused(publish(second, R"({"expected": null})"), kStatusConflict, "conflict", "not none as expected");
  EXPECT_EQ(Good(publish(second, "{}"))["previous"], first);
  ExpectRefused(publish(second, ""), kStatusConflict, "conflict", "in force already");
  ExpectRefused(publish(rejected, ""), kStatusBadRequest, "bad_input", "with a reason");
  EXPECT_EQ(Good(publish(rejected, R"({"reason": "checked by hand"})"))["reason"], "checked by hand");
  ExpectRefused(publish(first, R"({"expected": "one"})"), kStatusBadRequest, "bad_input", "'expected' must be");
  EXPECT_EQ(Good(Ask("POST", "/api/v1/calibrations/rollback"))["revision"], second);
  EXPECT_EQ(Good(Ask("POST", "/api/v1/calibrations/rollback", R"({"revision": 1, "expected": 2})"))["revision"], first);
  ExpectRefused(Ask("POST", "/api/v1/calibrations/rollback"), kStatusBadRequest, "bad_input", "no earlier");
  EXPECT_EQ(Good(Ask("GET", "/api/v1/calibrations"))["in_force"], first);
  EXPECT_EQ(Ask("GET", "/api/v1/calibrations/1", "", {{"content", "calibration"}}).body,
            ExampleRevision("studio", 1).calibration_text);
  ExpectRefused(Ask("GET", "/api/v1/calibrations/1", "", {{"content", "soul"}}), kStatusBadRequest, "bad_input",
                "?content=");
}

TEST_F(ApiTest, EventsTellEachChangeAndTheEnd) {
  const int id = bench_.Submit();
  ApiReply reply = Ask("GET", "/api/v1/jobs/1/events");
  ASSERT_TRUE(reply.events);
  EXPECT_EQ(reply.type, "text/event-stream");
  EXPECT_THAT(*reply.events->next(), HasSubstr(R"("state":"queued")"));
  bench_.queue.TakeNext();
  EXPECT_THAT(*reply.events->next(), HasSubstr(R"("state":"running")"));
  bench_.queue.Report(id, {.run = {.stage = "stereo", .stage_share = 0.5}});
  EXPECT_THAT(*reply.events->next(), HasSubstr(R"("text":"stereo: 50 %")"));
  bench_.queue.End(id, JobOutcome{.message = "well", .exit_status = kJobAccepted});
  const std::string last = *reply.events->next();
  EXPECT_THAT(last, HasSubstr(R"("exit_status":0)"));
  EXPECT_THAT(last, ::testing::MatchesRegex("id: [0-9]+\nevent: job\ndata: \\{.*\\}\n\n"));
  EXPECT_FALSE(reply.events->next());
}

TEST_F(ApiTest, NoMoreThanSoManyFollow) {
  bench_.Submit();
  std::optional<ApiReply> first = Ask("GET", "/api/v1/jobs/1/events");
  const ApiReply second = Ask("GET", "/api/v1/jobs/1/events");
  ExpectRefused(Ask("GET", "/api/v1/jobs/1/events"), kStatusUnavailable, "too_many_streams", "2 clients");
  first.reset();
  EXPECT_TRUE(Ask("GET", "/api/v1/jobs/1/events").events);
}

TEST_F(ApiTest, StatusAndMetricsSayWhereThingsStand) {
  EXPECT_TRUE(Good(Ask("GET", "/api/v1/status"))["in_force"].is_null());
  ASSERT_TRUE(store_->Publish(ExampleRequest("studio", Store(1), {})));
  bench_.Submit();
  bench_.queue.TakeNext();
  const Json status = Good(Ask("GET", "/api/v1/status"));
  EXPECT_EQ(status["in_force"]["revision"], 1);
  EXPECT_EQ(status["running"]["id"], 1);
  EXPECT_EQ(status["rig"]["name"], "studio");
  api_->CountEnded({.kind = "capture", .state = JobState::kFailed});
  const std::string metrics = Ask("GET", "/metrics").body;
  EXPECT_THAT(metrics, HasSubstr("rigcal_job_running 1\n"));
  EXPECT_THAT(metrics, HasSubstr("rigcal_revision_in_force 1\n"));
  EXPECT_THAT(metrics, HasSubstr("rigcal_jobs_ended_total{kind=\"capture\",state=\"failed\"} 1\n"));
  EXPECT_EQ(Good(Ask("GET", "/healthz"))["status"], "ok");
}

TEST(ErrorCodes, HaveNamesThatReadBack) {
  for (const ErrorCode code :
       {ErrorCode::kBadInput, ErrorCode::kNotFound, ErrorCode::kIo, ErrorCode::kDiskFull, ErrorCode::kUnsupported,
        ErrorCode::kCancelled, ErrorCode::kTimeout, ErrorCode::kDevice, ErrorCode::kConflict}) {
    EXPECT_EQ(ErrorCodeFromName(NameOf(code)), code);
  }
}

}  // namespace
}  // namespace rigcal
