#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <numbers>
#include <numeric>
#include <set>

#include "config/board_file.h"
#include "config/read_file.h"
#include "config/recording_file.h"
#include "config/rig_file.h"
#include "daemon/capture_run.h"
#include "daemon/cli/ask_operator.h"
#include "daemon/cli/command.h"
#include "daemon/cli/run_request.h"
#include "daemon/recorded_pictures_source.h"
#include "daemon/rig_lock.h"
#include "drivers/registry.h"

namespace rigcal {
namespace {

constexpr const char* kDriverReplay = "replay";

struct CaptureArguments {
  std::filesystem::path rig, replay, out, run_folder;
  std::vector<double> stops;  ///< degrees or metres
  std::string subject;
  bool resume = false, recorded_speed = false;
};

/// What is to be captured with which devices.
struct PreparedCapture {
  RigHardware hardware;
  DriverContext context;
  CaptureRequest request;
};

/// "2025-01-31T12:00:00.25Z"
std::string UtcNow() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto hundredths = std::chrono::duration_cast<std::chrono::duration<long long, std::centi>>(now).count();
  const std::time_t seconds = hundredths / 100;
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:02}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday,
                     utc.tm_hour, utc.tm_min, utc.tm_sec, hundredths % 100);
}

std::optional<Subject> SubjectNamed(const std::string& name) {
  for (const Subject subject : {Subject::kChart, Subject::kObject, Subject::kBoth}) {
    if (name == NameOf(subject)) return subject;
  }
  return std::nullopt;
}

std::vector<int> AllOf(std::size_t num_cameras) {
  std::vector<int> cameras(num_cameras);
  std::iota(cameras.begin(), cameras.end(), 0);
  return cameras;
}

/// All cameras at every place, stops named by their numbers.
std::vector<PlannedStop> PlanOf(const std::vector<std::vector<double>>& places, std::size_t num_cameras) {
  const std::size_t digits = std::max<std::size_t>(2, std::to_string(places.empty() ? 0 : places.size() - 1).size());
  std::vector<PlannedStop> stops;
  for (std::size_t s = 0; s < places.size(); ++s) {
    stops.push_back({{fmt::format("{:0{}}", s, digits), places[s]}, AllOf(num_cameras)});
  }
  return stops;
}

/// The stops of an arm, which says them itself: all cameras at each.
AcquisitionPlan PlanOfArm(std::size_t num_cameras) {
  return {.cameras_at = [num_cameras](const RecordedStop&) -> Result<std::vector<int>> { return AllOf(num_cameras); }};
}

/// The places of --stops, or else of the rig file.
Result<std::vector<std::vector<double>>> PlacesOf(const CaptureArguments& arguments, const RigFile& rig) {
  const std::string file = arguments.rig.string();
  const std::vector<AxisSettings>& axes = rig.positioner.axes;
  std::vector<std::vector<double>> places = rig.capture.stops;
  if (!arguments.stops.empty()) {
    if (axes.size() != 1) {
      return Fail(ErrorCode::kBadInput, "--stops: {} has {} axes, the option gives one value a stop", file,
                  axes.size());
    }
    places.clear();
    const double to_si = axes.front().unit == AxisUnit::kRadian ? std::numbers::pi / 180 : 1;
    for (const double value : arguments.stops) places.push_back({value * to_si});
  }
  if (rig.positioner.driver.empty()) {
    if (places.size() > 1) {
      return Fail(ErrorCode::kUnsupported, "{}: no driver moves its positioner, and {} stops are asked for", file,
                  places.size());
    }
    return std::vector<std::vector<double>>{{}};
  }
  if (places.empty()) return Fail(ErrorCode::kBadInput, "{}: has no [stops], and no --stops are given", file);
  return places;
}

Result<void> PrepareFromRig(const CaptureArguments& arguments, PreparedCapture& capture) {
  Result<RigFile> rig = LoadRig(arguments.rig);
  if (!rig) return Fail(rig.error());
  if (rig->cameras.empty()) {
    return Fail(ErrorCode::kBadInput, "{}: has no [[camera]], there is nothing to capture with",
                arguments.rig.string());
  }
  capture.request.subject = SubjectNamed(arguments.subject).value_or(Subject::kObject);
  capture.request.id = std::filesystem::absolute(arguments.out / ".").lexically_normal().parent_path().filename();
  const bool arm = rig->model.positioner.kind == PositionerKind::kArm && !rig->positioner.driver.empty();
  if (arm && arguments.stops.empty()) {
    capture.request.plan = PlanOfArm(rig->cameras.size());
    capture.request.same_place_rad = rig->positioner.position_tolerance_rad;
    capture.request.same_place_m = rig->positioner.position_tolerance_m;
  } else {
    const Result<std::vector<std::vector<double>>> places = PlacesOf(arguments, *rig);
    if (!places) return Fail(places.error());
    capture.request.plan.stops = PlanOf(*places, rig->cameras.size());
  }
  capture.request.plan.settle_s = rig->positioner.settle_s;
  capture.request.plan.settings = rig->capture;
  capture.hardware = {.cameras = rig->cameras, .positioner = rig->positioner};
  if (rig->sim) capture.hardware.sim = *rig->sim;
  if (rig->replay) capture.hardware.replay = *rig->replay;
  if (rig->board.empty()) return {};
  const Result<std::string> text = ReadFile(rig->board);
  if (!text) return Fail(text.error());
  Result<Board> board = ParseBoard(*text, rig->board.string());
  if (!board) return Fail(board.error());
  capture.context.board = std::move(*board);
  return {};
}

/// The subject of all views, or the one that was asked for.
Result<Subject> SubjectOf(const CaptureArguments& arguments, const Recording& recording) {
  if (const auto subject = SubjectNamed(arguments.subject)) return *subject;
  std::set<Subject> subjects;
  for (const RecordedView& view : recording.views) subjects.insert(view.subject);
  if (subjects.size() == 1) return *subjects.begin();
  return Fail(ErrorCode::kBadInput, "{}: shows {} subjects, --what chooses one", arguments.replay.string(),
              subjects.size());
}

/// The recording as it is: what a closed one does not have is not asked for, pictures were judged when they were taken.
Result<void> PrepareFromReplay(const CaptureArguments& arguments, PreparedCapture& capture) {
  const Result<Recording> recording = LoadRecording(arguments.replay);
  if (!recording) return Fail(recording.error());
  const Result<Subject> subject = SubjectOf(arguments, *recording);
  if (!subject) return Fail(subject.error());
  CaptureRequest& request = capture.request;
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
  return {};
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

Result<CaptureOutcome> RunCapture(const CaptureArguments& arguments, PreparedCapture& capture, Clock& clock,
                                  const CommandSession& session) {
  capture.context.clock = &clock;
  capture.context.subject = capture.request.subject;
  capture.context.open_recording = OpenRecordedPictures;
  capture.context.tell = [](const std::string& sentence) { fmt::print(stderr, "{}\n", sentence); };
  if (OperatorIsThere()) capture.context.confirm = AskOperator;
  capture.request.out = arguments.out;
  capture.request.resume = arguments.resume;
  const Result<OpenedRig> rig = OpenRig(capture.hardware, capture.context, session.stop);
  if (!rig) return Fail(rig.error());
  if (rig->real) capture.request.plan.utc_now = UtcNow;
  AcquisitionDevices devices{.positioner = rig->positioner.get(), .clock = &clock};
  for (const auto& camera : rig->cameras) devices.cameras.push_back(camera.get());
  std::function<void(const AcquisitionProgress&)> listener;
  if (session.on_terminal) {
    listener = [](const AcquisitionProgress& progress) {
      const std::string of = progress.num_stops ? fmt::format(" of {}", *progress.num_stops) : "";
      fmt::print(stderr, "\r\x1b[Kcapture: stop {}{}: {}", progress.stop + 1, of, NameOf(progress.phase));
    };
  }
  Result<CaptureOutcome> outcome = CaptureRecording(devices, capture.request, listener, session.stop);
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
  PreparedCapture capture;
  const bool replays = !arguments.replay.empty();
  const Result<void> prepared = replays ? PrepareFromReplay(arguments, capture) : PrepareFromRig(arguments, capture);
  if (!prepared) return FailWith("capture", prepared.error());
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
  const Result<CaptureOutcome> outcome = RunCapture(arguments, capture, clock, session);
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

}  // namespace

void AddCaptureCommand(CLI::App& app, CommandSession& session) {
  CLI::App* command = app.add_subcommand("capture", "Take a recording with the devices of a rig");
  auto arguments = std::make_shared<CaptureArguments>();
  arguments->run_folder = DefaultRunFolder();
  CLI::Option_group* source = command->add_option_group("devices");
  CLI::Option* rig = source->add_option("--rig", arguments->rig, "rig.toml: cameras, positioner and stops");
  CLI::Option* replay = source->add_option("--replay", arguments->replay, "A recording stands for all devices");
  source->require_option(1);
  command->add_option("--out", arguments->out, "Folder of the recording; must not be there, or be empty")->required();
  command
      ->add_option("--stops", arguments->stops,
                   "Where pictures are taken, in degrees or metres, instead of the rig's "
                   "stops; for a rig with one axis")
      ->delimiter(',')
      ->needs(rig);
  command->add_option("--what", arguments->subject, "What is seen: object unless said, of a replay what was seen")
      ->check(CLI::IsMember({"chart", "object", "both"}));
  command->add_flag("--resume", arguments->resume, "--out was interrupted: take only what is missing");
  command->add_flag("--recorded-speed", arguments->recorded_speed, "A replay takes as long as the recording did")
      ->needs(replay);
  command->add_option("--run-dir", arguments->run_folder, "Folder that says who holds a rig")->capture_default_str();
  command->callback([arguments, &session] { session.exit_status = Capture(*arguments, session); });
}

}  // namespace rigcal
