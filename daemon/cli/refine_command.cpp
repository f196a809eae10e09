#include <fmt/format.h>

#include <memory>

#include "daemon/cli/command.h"
#include "daemon/cli/number_options.h"
#include "daemon/cli/progress_line.h"
#include "daemon/cli/run_options.h"

namespace rigcal {
namespace {

int Refine(const RunRequest& request, const CommandSession& session) {
  ProgressLine line(session.on_terminal, MonotonicSeconds);
  RunContext context(session.stop, NumThreads(request.num_threads), MonotonicSeconds,
                     [&line](const RunProgress& progress) { line.Show(progress); });
  const auto rig = RefineFiles(request, context);
  line.Clear();
  if (!rig) return FailWith("refine", rig.error());
  fmt::print("{}", request.json ? ReportText(rig->report) : VerdictText(rig->report));
  return rig->report.validation.verdict == Verdict::kAccepted ? kExitAccepted : kExitNotAccepted;
}

/// The cameras of before in the order of the judged views. Errors also: kBadInput when one is missing.
Result<std::optional<RigCalibration>> LoadPrior(const RunRequest& request, const PreparedRun& run) {
  if (request.prior.empty()) return std::nullopt;
  auto loaded = LoadCameras(request.prior, run.pictures.naming);
  if (!loaded) return Fail(loaded.error());
  RigCalibration prior = loaded->calibration;
  prior.covariance.reset();
  prior.views.clear();
  for (const View& judged : run.cameras.calibration.views) {
    const auto before = std::ranges::find(loaded->calibration.views, judged.name, &View::name);
    if (before == loaded->calibration.views.end()) {
      return Fail(ErrorCode::kBadInput, "{}: has no camera for '{}', which is to be judged", request.prior.string(),
                  judged.name);
    }
    prior.views.push_back(*before);
  }
  return prior;
}

int ValidateCameras(const RunRequest& request, const CommandSession& session) {
  ProgressLine line(session.on_terminal, MonotonicSeconds);
  RunContext context(session.stop, NumThreads(request.num_threads), MonotonicSeconds,
                     [&line](const RunProgress& progress) { line.Show(progress); });
  auto run = PrepareRun(request, context);
  if (!run) return line.Clear(), FailWith("validate", run.error());
  const auto prior = LoadPrior(request, *run);
  if (!prior) return line.Clear(), FailWith("validate", prior.error());
  auto rig = ValidateRig(run->images.images, run->cameras.calibration, *prior, run->options, context);
  line.Clear();
  if (!rig) return FailWith("validate", rig.error());
  ReportInput(*run, rig->report);
  fmt::print("{}", request.json ? ReportText(rig->report) : VerdictText(rig->report));
  return rig->report.validation.verdict == Verdict::kAccepted ? kExitAccepted : kExitNotAccepted;
}

}  // namespace

void AddRefineCommand(CLI::App& app, CommandSession& session) {
  CLI::App* command = app.add_subcommand("refine", "Correct roughly right cameras from photographs");
  auto request = std::make_shared<RunRequest>();
  AddRunOptions(*command, *request);
  command->add_option("--out", request->out, "Folder for the results")->required();
  command->add_option("--intrinsics", request->intrinsics, "per-camera, fixed or per-view")
      ->check(CLI::IsMember({"per-camera", "fixed", "per-view"}));
  command
      ->add_option("--poses", request->poses,
                   "rig: as the cameras' rig gives them at the recording's stops; free; auto: rig where there is one")
      ->check(CLI::IsMember({"auto", "rig", "free"}));
  command->add_option("--fix-cameras", request->fixed_cameras, "Cameras (or views) that stay as they are")
      ->delimiter(',');
  command->add_option("--method", request->method, "rigcal, or paper: the recipe as printed")
      ->check(CLI::IsMember({"rigcal", "paper"}));
  command->add_option("--rounds", request->num_rounds, "Rounds of stereo, matching, adjustment")
      ->check(CLI::Range(1, 20));
  command->add_option("--holdout", request->holdout_share, "Share of the tracks kept to judge the result")
      ->check(NumberWithin(0.05, 0.5));
  command->callback([request, &session] { session.exit_status = Refine(*request, session); });
}

void AddValidateCommand(CLI::App& app, CommandSession& session) {
  CLI::App* command = app.add_subcommand("validate", "The verdict alone, on cameras from anywhere");
  auto request = std::make_shared<RunRequest>();
  request->intrinsics = "per-view";
  request->poses = "file";
  AddRunOptions(*command, *request);
  command->add_option("--prior", request->prior, "The cameras of before, to judge the distance from");
  command->callback([request, &session] { session.exit_status = ValidateCameras(*request, session); });
}

}  // namespace rigcal
