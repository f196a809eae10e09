#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <set>

#include "config/recording_file.h"
#include "config/rig_file.h"
#include "daemon/capture_request.h"
#include "daemon/cli/ask_operator.h"
#include "daemon/cli/command.h"
#include "daemon/cli/service_commands.h"
#include "daemon/rig_lock.h"

namespace rigcal {
namespace {

constexpr const char* kDriverReplay = "replay";

struct CaptureArguments {
  std::filesystem::path rig, replay, out, run_folder;
  std::vector<double> stops;  ///< degrees or metres
  std::string subject;
  bool resume = false, recorded_speed = false, wait = false;
  ServiceChoice service;
};

/// The subject of all views, or the one that was asked for.
Result<Subject> SubjectOf(const CaptureArguments& arguments, const Recording& recording) {
  if (const auto subject = SubjectNamed(arguments.subject)) return *subject;
  std::set<Subject> subjects;
  for (const RecordedView& view : recording.views) subjects.insert(view.subject);
  if (subjects.size() == 1) return *subjects.begin();
  return Fail(ErrorCode::kBadInput, "{}: shows {} subjects, --what chooses one", arguments.replay.string(),
              subjects.size());
}

Result<PreparedCapture> PrepareFromRig(const CaptureArguments& arguments) {
  const Result<RigFile> rig = LoadRig(arguments.rig);
  if (!rig) return Fail(rig.error());
  const CaptureWish wish{.out = arguments.out,
                         .subject = SubjectNamed(arguments.subject).value_or(Subject::kObject),
                         .stops = arguments.stops,
                         .resume = arguments.resume};
  return PrepareCapture(wish, *rig, arguments.rig.string());
}

/// The recording as it is: what a closed one does not have is not asked for, pictures were judged when they were taken.
Result<PreparedCapture> PrepareFromReplay(const CaptureArguments& arguments) {
  PreparedCapture capture;
  const Result<Recording> recording = LoadRecording(arguments.replay);
  if (!recording) return Fail(recording.error());
  const Result<Subject> subject = SubjectOf(arguments, *recording);
  if (!subject) return Fail(subject.error());
  CaptureRequest& request = capture.request;
  request.out = arguments.out;
  request.resume = arguments.resume;
  request.subject = *subject;
  request.id = recording->id;
  request.plan.settings = {.max_saturated = 1, .min_brightness = 0, .min_sharpness = 0, .refuse_identical = false};
  request.plan.settings.retakes = 0;
  for (const RecordedCamera& camera : recording->cameras) {
    capture.hardware.cameras.push_back({.id = camera.id, .driver = kDriverReplay});
  }
  capture.hardware.positioner = {.driver = kDriverReplay};
  capture.hardware.replay = {.recording = arguments.replay.string(), .at_recorded_speed = arguments.recorded_speed};
  for (int s = 0; s < static_cast<int>(recording->stops.size()); ++s) {
    const RecordedStop& stop = recording->stops[s];
    PlannedStop planned{.target = {.id = stop.id}};
    for (const AxisPosition& axis : stop.axes) planned.target.axes.push_back(axis.commanded);
    for (int c = 0; c < static_cast<int>(recording->cameras.size()); ++c) {
      const bool has = std::ranges::any_of(recording->views, [&](const RecordedView& view) {
        return view.camera == c && view.stop == s && view.subject == *subject;
      });
      if (has || !recording->closed) planned.cameras.push_back(c);
    }
    request.order.stops.push_back(stop.id);
    request.plan.stops.push_back(std::move(planned));
  }
  for (const RecordedView& view : recording->views) request.order.views.push_back(view.file);
  return capture;
}

std::string SpentText(const CaptureOutcome& outcome, double elapsed_s) {
  const AcquisitionTimes& times = outcome.acquisition.times;
  const double whole_s = std::max(1e-9, times.moving_s + times.settling_s + times.taking_s + times.storing_s);
  return fmt::format(
      "{:.1f} s: moving {:.0f} %, settling {:.0f} %, taking {:.0f} %, waiting for the disk {:.0f} %; {:.1f} pictures a "
      "second; {} retaken, {} cameras brought back",
      elapsed_s, 100 * times.moving_s / whole_s, 100 * times.settling_s / whole_s, 100 * times.taking_s / whole_s,
      100 * times.storing_s / whole_s, outcome.acquisition.num_pictures / whole_s, outcome.acquisition.num_retaken,
      outcome.acquisition.num_recovered);
}

Result<CaptureOutcome> RunCapture(PreparedCapture& capture, Clock& clock, const CommandSession& session) {
  capture.context.tell = [](const std::string& sentence) { fmt::print(stderr, "{}\n", sentence); };
  if (OperatorIsThere()) capture.context.confirm = AskOperator;
  std::function<void(const AcquisitionProgress&)> listener;
  if (session.on_terminal) {
    listener = [](const AcquisitionProgress& progress) {
      const std::string of = progress.num_stops ? fmt::format(" of {}", *progress.num_stops) : "";
      fmt::print(stderr, "\r\x1b[Kcapture: stop {}{}: {}", progress.stop + 1, of, NameOf(progress.phase));
    };
  }
  Result<CaptureOutcome> outcome = CaptureWithDevices(capture, clock, listener, session.stop);
  if (session.on_terminal) fmt::print(stderr, "\r\x1b[K");
  return outcome;
}

/// What is kept of an interrupted recording, and how it goes on.
void PrintWhatIsKept(const std::filesystem::path& out) {
  const Result<Recording> recording = LoadRecording(out);
  if (!recording || recording->closed) return;
  fmt::print(stderr, "{}: {} views are kept, the same command with --resume takes the others\n", out.string(),
             recording->views.size());
}

int Capture(const CaptureArguments& arguments, const CommandSession& session) {
  const bool replays = !arguments.replay.empty();
  Result<PreparedCapture> capture = replays ? PrepareFromReplay(arguments) : PrepareFromRig(arguments);
  if (!capture) return FailWith("capture", capture.error());
  std::optional<RigLock> lock;
  if (!replays) {
    Result<RigLock> taken =
        RigLock::Take(arguments.run_folder, arguments.rig,
                      {.what = "rigcal capture --out " + arguments.out.string(), .ask_instead = {}});
    if (!taken) return FailWith("capture", taken.error());
    lock.emplace(std::move(*taken));
  }
  SystemClock clock;
  const double begin_s = clock.NowS();
  const Result<CaptureOutcome> outcome = RunCapture(*capture, clock, session);
  if (!outcome) {
    const int status = FailWith("capture", outcome.error());
    PrintWhatIsKept(arguments.out);
    return status;
  }
  const Recording& recording = outcome->recording;
  fmt::print("{}: {} cameras, {} stops, {} views\n", arguments.out.string(), recording.cameras.size(),
             recording.stops.size(), recording.views.size());
  fmt::print("{}\n", SpentText(*outcome, clock.NowS() - begin_s));
  return kExitAccepted;
}

/// Without devices of its own, the command asks the service, which keeps the recording.
int AskServiceToCapture(const CaptureArguments& arguments, const CommandSession& session) {
  if (!arguments.out.empty() || arguments.resume) {
    return FailWith("capture", {ErrorCode::kBadInput,
                                "--out and --resume need --rig or --replay; without, the service takes the recording "
                                "into its state folder"});
  }
  nlohmann::json request = nlohmann::json::object();
  if (!arguments.subject.empty()) request["what"] = arguments.subject;
  if (!arguments.stops.empty()) request["stops"] = arguments.stops;
  return AskForJob("capture", "capture", request, arguments.wait, arguments.service, session);
}

int RunCaptureCommand(const CaptureArguments& arguments, const CommandSession& session) {
  if (arguments.rig.empty() && arguments.replay.empty()) return AskServiceToCapture(arguments, session);
  if (!arguments.out.empty()) return Capture(arguments, session);
  return FailWith("capture", {ErrorCode::kBadInput, "--out is missing, the folder of the recording"});
}

}  // namespace

void AddCaptureCommand(CLI::App& app, CommandSession& session) {
  CLI::App* command =
      app.add_subcommand("capture", "Take a recording with the devices of a rig, or let the service do so");
  auto arguments = std::make_shared<CaptureArguments>();
  arguments->run_folder = DefaultRunFolder();
  CLI::Option_group* source = command->add_option_group("devices");
  source->add_option("--rig", arguments->rig, "rig.toml: cameras, positioner and stops");
  CLI::Option* replay = source->add_option("--replay", arguments->replay, "A recording stands for all devices");
  source->require_option(0, 1);
  command->add_option("--out", arguments->out, "Folder of the recording; must not be there, or be empty");
  command
      ->add_option("--stops", arguments->stops,
                   "Where pictures are taken, in degrees or metres, instead of the rig's "
                   "stops; for a rig with one axis")
      ->delimiter(',')
      ->excludes(replay);
  command->add_option("--what", arguments->subject, "What is seen: object unless said, of a replay what was seen")
      ->check(CLI::IsMember({"chart", "object", "both"}));
  command->add_flag("--resume", arguments->resume, "--out was interrupted: take only what is missing");
  command->add_flag("--recorded-speed", arguments->recorded_speed, "A replay takes as long as the recording did")
      ->needs(replay);
  command->add_option("--run-dir", arguments->run_folder, "Folder that says who holds a rig")->capture_default_str();
  AddServiceOptions(*command, arguments->service);
  command->add_flag("--wait", arguments->wait, "Of the service: show the progress, and end as the job ends");
  command->callback([arguments, &session] { session.exit_status = RunCaptureCommand(*arguments, session); });
}

}  // namespace rigcal
