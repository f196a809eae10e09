#include "daemon/cli/service_commands.h"

#include <fmt/format.h>

#include <cstdio>

#include "daemon/api/http_server.h"
#include "daemon/cli/store_options.h"

namespace rigcal {
namespace {

using Json = nlohmann::json;

constexpr const char* kErase = "\r\x1b[K";

std::string TextOf(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}

/// "job 7 (recalibrate): done: revision 3: accepted".
std::string JobLine(const Json& job) {
  std::string line = fmt::format("job {} ({}): {}", job.value("id", 0), TextOf(job, "kind"), TextOf(job, "state"));
  if (job.contains("outcome") && job["outcome"].is_object()) line += ": " + TextOf(job["outcome"], "message");
  if (job.contains("progress") && job["progress"].is_object()) line += ": " + TextOf(job["progress"], "text");
  return line;
}

/// What can be done with a recording that a job left behind.
std::string AdviceFor(const Json& job) {
  const std::string recording = TextOf(job, "recording"), state = TextOf(job, "state"), kind = TextOf(job, "kind");
  if (recording.empty() || state == "done" || state == "running") return "";
  const std::string again = kind == "replay" ? "replay " : kind + " --recording ";
  return fmt::format("its recording is kept: rigcal {}{}\n", again, recording);
}

}  // namespace

void AddServiceOptions(CLI::App& command, ServiceChoice& choice) {
  choice.socket = DefaultSocket();
  command.add_option("--socket", choice.socket, "Socket of the service")->capture_default_str();
  command.add_flag("--json", choice.json, "Print JSON");
}

int ServiceFailWith(const char* command, const Error& error) {
  fmt::print(stderr, "rigcal {}: {}\n", command, error.message);
  switch (error.code) {
    case ErrorCode::kBadInput:
    case ErrorCode::kNotFound:
    case ErrorCode::kConflict:
    case ErrorCode::kUnsupported:
      return kExitBadInput;
    default:
      return kExitInternal;
  }
}

int FollowJob(const char* command, int id, const ServiceChoice& choice, const CommandSession& session) {
  Json last;
  const auto show = [&](const Json& job) {
    last = job;
    if (session.on_terminal) fmt::print(stderr, "{}{}", kErase, JobLine(job));
    return true;
  };
  const auto followed = ApiClient(choice.socket).Follow(fmt::format("/api/v1/jobs/{}/events", id), show, session.stop);
  if (session.on_terminal) fmt::print(stderr, "{}", kErase);
  if (!followed) return ServiceFailWith(command, followed.error());
  if (!last.is_object() || !last["outcome"].is_object()) {
    return ServiceFailWith(command, {ErrorCode::kIo, fmt::format("the service stopped before job {} ended", id)});
  }
  fmt::print("{}\n", choice.json ? last.dump(2) : JobLine(last));
  if (!choice.json) fmt::print("{}", AdviceFor(last));
  return last["outcome"].value("exit_status", kExitInternal);
}

int AskForJob(const char* command, const std::string& kind, const Json& request, bool wait, const ServiceChoice& choice,
              const CommandSession& session) {
  const Json body = {{"kind", kind}, {"request", request}, {"by", UserName()}};
  const Result<Json> job = ApiClient(choice.socket).Post("/api/v1/jobs", body);
  if (!job) return ServiceFailWith(command, job.error());
  const int id = job->value("id", 0);
  if (wait) return FollowJob(command, id, choice, session);
  fmt::print("{}\n",
             choice.json ? job->dump(2) : fmt::format("job {} is queued; `rigcal watch {}` follows it", id, id));
  return kExitAccepted;
}

namespace {

struct ServiceArguments {
  ServiceChoice choice;
  int id = 0, count = 20;
};

std::string StatusText(const Json& status) {
  const Json &rig = status["rig"], &in_force = status["in_force"], &running = status["running"];
  std::string text = fmt::format("rig '{}' ({})\n", TextOf(rig, "name"), TextOf(rig, "file"));
  for (const Json& camera : rig["cameras"]) {
    text += fmt::format("camera {}: {}\n", TextOf(camera, "id"), TextOf(camera, "driver"));
  }
  text += in_force.is_null() ? std::string("no calibration is in force; `rigcal seed-chart` makes the first\n")
                             : fmt::format("revision {} is in force since {}, now {}\n", in_force.value("revision", 0),
                                           TextOf(in_force, "published_at"), TextOf(status, "time"));
  text += running.is_null() ? "no job runs" : JobLine(running);
  text += fmt::format("; {} wait\n", status.value("num_waiting", 0));
  for (const Json& job : status["last_jobs"]) {
    if (TextOf(job, "state") != "running") text += JobLine(job) + "\n";
  }
  return text;
}

int RunStatus(const ServiceArguments& arguments, const CommandSession& /*session*/) {
  const Result<Json> status = ApiClient(arguments.choice.socket).Get("/api/v1/status");
  if (!status) return ServiceFailWith("status", status.error());
  fmt::print("{}", arguments.choice.json ? status->dump(2) + "\n" : StatusText(*status));
  return kExitAccepted;
}

int RunJobs(const ServiceArguments& arguments, const CommandSession& /*session*/) {
  const Result<Json> jobs =
      ApiClient(arguments.choice.socket).Get(fmt::format("/api/v1/jobs?count={}", arguments.count));
  if (!jobs) return ServiceFailWith("jobs", jobs.error());
  if (arguments.choice.json) fmt::print("{}\n", jobs->dump(2));
  for (const Json& job : (*jobs)["jobs"]) {
    if (!arguments.choice.json) fmt::print("{}  {}\n", TextOf(job, "queued_at"), JobLine(job));
  }
  return kExitAccepted;
}

/// Prints a job as it stands.
int PrintJob(const char* command, const Result<Json>& job, const ServiceChoice& choice) {
  if (!job) return ServiceFailWith(command, job.error());
  if (choice.json) {
    fmt::print("{}\n", job->dump(2));
    return kExitAccepted;
  }
  fmt::print("{}\nasked by {} at {}: {}\n", JobLine(*job), TextOf(*job, "by"), TextOf(*job, "queued_at"),
             (*job)["request"].dump());
  if (const std::string begun = TextOf(*job, "begun_at"); !begun.empty()) fmt::print("begun {}\n", begun);
  if (const std::string ended = TextOf(*job, "ended_at"); !ended.empty()) fmt::print("ended {}\n", ended);
  if (const std::string recording = TextOf(*job, "recording"); !recording.empty()) {
    fmt::print("recording {}\n", recording);
  }
  fmt::print("{}", AdviceFor(*job));
  return kExitAccepted;
}

int RunJob(const ServiceArguments& arguments, const CommandSession& /*session*/) {
  return PrintJob("job", ApiClient(arguments.choice.socket).Get(fmt::format("/api/v1/jobs/{}", arguments.id)),
                  arguments.choice);
}

int RunCancel(const ServiceArguments& arguments, const CommandSession& /*session*/) {
  const std::string path = fmt::format("/api/v1/jobs/{}/cancel", arguments.id);
  return PrintJob("cancel", ApiClient(arguments.choice.socket).Post(path, Json::object()), arguments.choice);
}

int RunWatch(const ServiceArguments& arguments, const CommandSession& session) {
  return FollowJob("watch", arguments.id, arguments.choice, session);
}

struct JobArguments {
  ServiceChoice choice;
  std::string recording;  ///< empty: a new one
  std::string masks;
  std::optional<double> expected_error_px;
  std::optional<int> num_rounds;
  bool wait = false;

  [[nodiscard]] Json Request() const {
    Json request = Json::object();
    std::error_code ignored;
    const bool is_here = std::filesystem::exists(recording, ignored);  // else the service knows the name
    if (!recording.empty()) request["recording"] = is_here ? std::filesystem::canonical(recording).string() : recording;
    if (!masks.empty()) request["masks"] = masks;
    if (expected_error_px) request["expected_error_px"] = *expected_error_px;
    if (num_rounds) request["rounds"] = *num_rounds;
    return request;
  }
};

CLI::App* AddJobCommand(CLI::App& app, CommandSession& session, const char* name, const char* what,
                        const std::shared_ptr<JobArguments>& arguments) {
  CLI::App* command = app.add_subcommand(name, what);
  AddServiceOptions(*command, arguments->choice);
  command->add_flag("--wait", arguments->wait, "Show the progress, and end as the job ends");
  command->callback([arguments, &session, name] {
    session.exit_status = AskForJob(name, name, arguments->Request(), arguments->wait, arguments->choice, session);
  });
  return command;
}

void AddRefineJobOptions(CLI::App& command, JobArguments& arguments) {
  command.add_option("--masks", arguments.masks, "auto or none")->check(CLI::IsMember({"auto", "none"}));
  command.add_option("--expected-error-px", arguments.expected_error_px, "Er: how many pixels the cameras may be off");
  command.add_option("--rounds", arguments.num_rounds, "Rounds of stereo, matching, adjustment");
}

}  // namespace

void AddServiceCommands(CLI::App& app, CommandSession& session) {
  auto arguments = std::make_shared<ServiceArguments>();
  const auto add = [&](const char* name, const char* what, int (*run)(const ServiceArguments&, const CommandSession&)) {
    CLI::App* command = app.add_subcommand(name, what);
    AddServiceOptions(*command, arguments->choice);
    command->callback([arguments, &session, run] { session.exit_status = run(*arguments, session); });
    return command;
  };
  add("status", "What the service does, and the calibration in force", RunStatus);
  constexpr int kMostListed = 500;
  add("jobs", "The newest jobs of the service", RunJobs)
      ->add_option("--count", arguments->count, "How many")
      ->check(CLI::Range(1, kMostListed));
  for (CLI::App* command : {add("job", "What became of a job", RunJob), add("cancel", "Stop a job", RunCancel),
                            add("watch", "Follow a job until it has ended", RunWatch)}) {
    command->add_option("N", arguments->id, "Number of the job")->required();
  }
  for (const auto& [name, what] : {std::pair{"recalibrate", "Take pictures and refine the calibration in force"},
                                   std::pair{"seed-chart", "Take pictures of the chart and calibrate from them"},
                                   std::pair{"replay", "Refine the calibration in force from a recording"}}) {
    auto job = std::make_shared<JobArguments>();
    CLI::App* command = AddJobCommand(app, session, name, what, job);
    const bool is_replay = std::string(name) == "replay";
    if (is_replay)
      command->add_option("RECORDING", job->recording, "Folder, or a name in the state folder")->required();
    if (!is_replay) command->add_option("--recording", job->recording, "One that is there; what it lacks is taken");
    if (std::string(name) != "seed-chart") AddRefineJobOptions(*command, *job);
  }
}

}  // namespace rigcal
