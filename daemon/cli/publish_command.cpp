#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "daemon/api/http_server.h"
#include "daemon/cli/command.h"
#include "daemon/cli/service_commands.h"
#include "daemon/cli/store_options.h"
#include "daemon/store_report.h"

namespace rigcal {
namespace {

struct PublishArguments {
  StoreChoice choice;
  std::string revision;  ///< rollback: empty for the step before
  std::string reason, expected;
  std::filesystem::path publish_dir;  ///< empty: the store alone
  std::vector<std::string> formats;
  bool undistorted = false;
  bool names_store = false;  ///< --state or --publish-dir: without the service
  ServiceChoice service;
};

Result<std::optional<int>> Expected(const PublishArguments& arguments, const std::optional<int>& in_force) {
  if (arguments.expected.empty()) return in_force;
  if (arguments.expected == "none") return std::nullopt;
  const auto number = RevisionNumber(arguments.expected);
  if (!number) return Fail(number.error());
  return *number;
}

Result<int> RollbackTarget(const PublishArguments& arguments, RigStore& opened) {
  if (!arguments.revision.empty()) return RevisionNumber(arguments.revision);
  const auto history = opened.store->History(opened.rig);
  if (!history) return Fail(history.error());
  if (const auto before = RevisionBefore(history->events)) return *before;
  return Fail(ErrorCode::kBadInput, "rig '{}': there is no earlier publication to roll back to", opened.rig);
}

PublishFolder TargetOf(const PublishArguments& arguments) {
  PublishFolder target{arguments.publish_dir, {}};
  for (const std::string& format : arguments.formats) target.formats.push_back({format, arguments.undistorted});
  return target;
}

Result<Published> PublishWith(const PublishArguments& arguments, const PublishRequest& request, CalibrationStore& store,
                              const std::stop_token& stop) {
  if (arguments.publish_dir.empty()) {
    const auto event = store.Publish(request);
    if (!event) return Fail(event.error());
    return Published{*event, {}};
  }
  SystemClock clock;
  return PublishRevision(store, request, TargetOf(arguments), clock, stop);
}

/// The revision is in force already: its files may be missing.
int WriteFiles(const char* name, const PublishArguments& arguments, RigStore& opened, const std::stop_token& stop) {
  SystemClock clock;
  const auto written = RepairPublished(*opened.store, opened.rig, TargetOf(arguments), clock, stop);
  if (!written) return FailWith(name, written.error());
  fmt::print("it is in force already; its files {}\n", *written ? "are written" : "were right");
  return kExitAccepted;
}

Result<nlohmann::json> ServiceRequest(const PublishArguments& arguments) {
  nlohmann::json body = {{"by", UserName()}, {"reason", arguments.reason}};
  if (arguments.expected.empty()) return body;
  body["expected"] = nullptr;
  if (arguments.expected == "none") return body;
  const auto expected = RevisionNumber(arguments.expected);
  if (!expected) return Fail(expected.error());
  body["expected"] = *expected;
  return body;
}

/// The service publishes where its rig file says, and knows the rig.
int RunByService(const char* name, PublishKind kind, const PublishArguments& arguments) {
  auto body = ServiceRequest(arguments);
  if (!body) return FailWith(name, body.error());
  std::string path = "/api/v1/calibrations/rollback";
  if (!arguments.revision.empty()) {
    const auto number = RevisionNumber(arguments.revision);
    if (!number) return FailWith(name, number.error());
    if (kind == PublishKind::kPublish) path = fmt::format("/api/v1/calibrations/{}/publish", *number);
    if (kind == PublishKind::kRollback) (*body)["revision"] = *number;
  }
  const auto published = ApiClient(arguments.service.socket).Post(path, *body);
  if (!published) return ServiceFailWith(name, published.error());
  for (const nlohmann::json& note : (*published)["notes"]) {
    fmt::print(stderr, "rigcal {}: note: {}\n", name, note.get<std::string>());
  }
  PublishEvent event{.time = published->value("time", ""),
                     .kind = kind,
                     .revision = published->value("revision", 0),
                     .by = published->value("by", ""),
                     .reason = published->value("reason", "")};
  if ((*published)["previous"].is_number()) event.previous = (*published)["previous"].get<int>();
  fmt::print("{}\n", EventText(event));
  return kExitAccepted;
}

int Run(const char* name, PublishKind kind, const PublishArguments& arguments, const CommandSession& session) {
  if (arguments.publish_dir.empty() && !arguments.formats.empty()) {
    return FailWith(name, {ErrorCode::kBadInput, "--format needs --publish-dir, the folder to write to"});
  }
  if (!arguments.names_store && ApiClient(arguments.service.socket).IsThere()) {
    return RunByService(name, kind, arguments);
  }
  auto opened = OpenRigStore(arguments.choice);
  if (!opened) return FailWith(name, opened.error());
  const auto in_force = NumberInForce(*opened);
  if (!in_force) return FailWith(name, in_force.error());
  const auto expected = Expected(arguments, *in_force);
  if (!expected) return FailWith(name, expected.error());
  // Read after what is in force: whoever publishes in between is noticed by compare-and-swap.
  const auto number =
      kind == PublishKind::kRollback ? RollbackTarget(arguments, *opened) : RevisionNumber(arguments.revision);
  if (!number) return FailWith(name, number.error());
  const bool is_in_force = *in_force == *number && *expected == *in_force;
  if (kind == PublishKind::kPublish && is_in_force && !arguments.publish_dir.empty()) {
    return WriteFiles(name, arguments, *opened, session.stop);
  }
  const PublishRequest request{.rig = opened->rig,
                               .revision = *number,
                               .expected = *expected,
                               .kind = kind,
                               .time = NowText(),
                               .by = UserName(),
                               .reason = arguments.reason};
  const auto published = PublishWith(arguments, request, *opened->store, session.stop);
  if (!published) return FailWith(name, published.error());
  for (const std::string& note : published->notes) fmt::print(stderr, "rigcal {}: note: {}\n", name, note);
  fmt::print("{}\n", EventText(published->event));
  return kExitAccepted;
}

}  // namespace

void AddPublishCommands(CLI::App& app, CommandSession& session) {
  auto arguments = std::make_shared<PublishArguments>();
  const auto add = [&](const char* name, const char* what, PublishKind kind) {
    CLI::App* command = app.add_subcommand(name, what);
    AddStoreOptions(*command, arguments->choice);
    command->add_option("--expected", arguments->expected,
                        "Revision that must be in force, or none; without it whatever is in force");
    command->add_option("--publish-dir", arguments->publish_dir, "Folder to write current.json and the formats to");
    command->add_option("--format", arguments->formats, "Format of `rigcal export` to write there, too");
    command->add_flag("--undistorted", arguments->undistorted, "Those formats for undistorted images");
    arguments->service.socket = DefaultSocket();
    command->add_option("--socket", arguments->service.socket, "Socket of the service")->capture_default_str();
    command->callback([arguments, &session, name, kind, command] {
      arguments->names_store = command->count("--state") + command->count("--publish-dir") > 0;
      session.exit_status = Run(name, kind, *arguments, session);
    });
    return command;
  };
  CLI::App* publish = add("publish", "Put a revision in force", PublishKind::kPublish);
  publish->add_option("REV", arguments->revision, "Number of the revision")->required();
  publish->add_option("--force", arguments->reason,
                      "Why it is published; needed for one that was not accepted, and kept");
  CLI::App* rollback = add("rollback", "Put an earlier revision in force again", PublishKind::kRollback);
  rollback->add_option("REV", arguments->revision, "Number of the revision; without it one step back");
  rollback->add_option("--reason", arguments->reason, "Why; is kept");
}

}  // namespace rigcal
