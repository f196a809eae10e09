#include <fmt/format.h>

#include <memory>

#include "config/atomic_file.h"
#include "config/read_file.h"
#include "config/rig_file.h"
#include "config/rig_views.h"
#include "daemon/cli/command.h"
#include "daemon/cli/number_options.h"
#include "daemon/cli/progress_line.h"
#include "daemon/drift_run.h"
#include "daemon/run_output.h"

namespace rigcal {
namespace {

constexpr const char* kCommand = "drift-check";

struct DriftRequest {
  std::filesystem::path recording, cameras, rig, out;
  std::vector<std::filesystem::path> earlier;
  std::optional<double> limit_px, expected_error_px;
  std::string masks = "auto";
  std::uint64_t random_seed = DriftOptions{}.random_seed;
  int num_threads = 0;  ///< 0: one for each processor
  bool json = false;
};

struct OpenedNight {
  NightRecording night;
  CalibrationInForce in_force;
  DriftOptions options;
  std::vector<EarlierNight> earlier;
};

Result<OpenedNight> Open(const DriftRequest& request) {
  OpenedNight opened{.night = {.folder = request.recording}};
  auto recorded = LoadRecordedObject(request.recording);
  if (!recorded) return Fail(recorded.error());
  opened.night.recorded = std::move(*recorded);
  auto rigged = LoadRiggedCameras(request.cameras);
  if (!rigged) return Fail(rigged.error());
  if (!rigged->has_value()) {
    return Fail(ErrorCode::kBadInput, "{}: has no rig, a drift check needs one; `rigcal seed --rig` makes one",
                request.cameras.string());
  }
  opened.in_force = {std::move((*rigged)->calibration), request.cameras.string(), (*rigged)->file.sha256};
  DriftOptions& options = opened.options;
  if (!request.rig.empty()) {
    const auto rig = LoadRig(request.rig);
    if (!rig) return Fail(rig.error());
    options.limits.drift_px = rig->drift.limit_px;
  }
  options.limits.drift_px = request.limit_px.value_or(options.limits.drift_px);
  options.expected_error_px = request.expected_error_px;
  options.masks = request.masks == "none" ? MaskSource::kNone : MaskSource::kAuto;
  options.random_seed = request.random_seed;
  for (const std::filesystem::path& file : request.earlier) {
    const auto text = ReadFile(file);
    if (!text) return Fail(text.error());
    auto night = ParseEarlierNight(*text, file.string());
    if (!night) return Fail(night.error());
    opened.earlier.push_back(std::move(*night));
  }
  return opened;
}

std::string TextFor(const DriftReport& report) {
  std::string text;
  for (const std::string& sentence : report.finding.sentences) text += sentence + "\n";
  for (const CameraDrift& drift : report.finding.cameras) {
    const auto px = [](const std::optional<double>& error) { return error ? fmt::format("{:.3f}", *error) : "-"; };
    text += fmt::format("  {:16} {:.3f} px, sigma {:.3f}; held-out tracks {} px before, {} px after; {} features\n",
                        drift.camera, drift.motion.moved_px, drift.motion.sigma_px, px(drift.evidence.before_px),
                        px(drift.evidence.after_px), drift.evidence.num_features);
  }
  for (const CameraTrend& trend : report.trend) {
    text += fmt::format("  {:16} {:.4f} +- {:.4f} px a day to the right, {:.4f} +- {:.4f} down ({} nights)\n",
                        trend.camera, trend.px_per_day.x(), trend.sigma_px_per_day.x(), trend.px_per_day.y(),
                        trend.sigma_px_per_day.y(), trend.num_nights);
  }
  return text;
}

int CheckNight(const DriftRequest& request, const CommandSession& session) {
  if (auto ready = PrepareResultFolder(request.out, request.cameras); !ready) return FailWith(kCommand, ready.error());
  ProgressLine line(session.on_terminal, MonotonicSeconds);
  RunContext context(session.stop, NumThreads(request.num_threads), MonotonicSeconds,
                     [&line](const RunProgress& progress) { line.Show(progress); });
  const Result<OpenedNight> opened = Open(request);
  if (!opened) return line.Clear(), FailWith(kCommand, opened.error());
  Result<DriftCheck> check = CheckDrift(opened->night, opened->in_force, opened->options, context);
  if (!check) return line.Clear(), FailWith(kCommand, check.error());
  DriftReport& report = check->report;
  if (!opened->earlier.empty()) report.trend = TrendOf(NightsWith(report, opened->earlier));

  const std::string text = DriftText(report);
  auto written = WriteFileAtomically(request.out / "drift.json", text);
  if (written) written = WriteTimingJson(context.Timing(), request.out / "timing.json");
  line.Clear();
  if (!written) return FailWith(kCommand, written.error());
  fmt::print("{}", request.json ? text : TextFor(report));
  return report.finding.state == DriftState::kOk ? kExitAccepted : kExitNotAccepted;
}

}  // namespace

void AddDriftCommand(CLI::App& app, CommandSession& session) {
  CLI::App* command = app.add_subcommand(kCommand, "Does the calibration in force still hold? Judged on a recording");
  auto request = std::make_shared<DriftRequest>();
  command->add_option("--recording", request->recording, "A small recording of any object (docs/drift.md)")->required();
  command->add_option("--cameras", request->cameras, "calibration.json in force, with its rig")->required();
  command->add_option("--out", request->out, "Folder for drift.json")->required();
  command->add_option("--rig", request->rig, "rig.toml with [drift]");
  command
      ->add_option("--limit-px", request->limit_px,
                   "A camera drifts when its picture of the object has moved by more; in place of the rig file's")
      ->check(NumberWithin(0.01, 10.0));
  command->add_option("--earlier", request->earlier, "drift.json of earlier nights, for the trend");
  command
      ->add_option("--expected-error-px", request->expected_error_px,
                   "Er: how many pixels the cameras may be off; estimated from the photographs when absent")
      ->check(NumberWithin(0.1, 31.0));
  command->add_option("--masks", request->masks, "auto: find silhouettes, or none")
      ->check(CLI::IsMember({"auto", "none"}))
      ->capture_default_str();
  command->add_option("--random-seed", request->random_seed, "Seed of every random choice");
  AddThreadsOption(*command, request->num_threads);
  command->add_flag("--json", request->json, "Print drift.json");
  command->callback([request, &session] { session.exit_status = CheckNight(*request, session); });
}

}  // namespace rigcal
