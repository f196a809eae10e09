#include "daemon/capture_request.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <numbers>
#include <numeric>

#include "config/board_file.h"
#include "config/read_file.h"
#include "config/recording_file.h"
#include "daemon/recorded_pictures_source.h"
#include "drivers/registry.h"

namespace rigcal {
namespace {

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

/// The places that are wished for, or else those of the rig file.
Result<std::vector<std::vector<double>>> PlacesOf(const CaptureWish& wish, const RigFile& rig,
                                                  const std::string& file) {
  const std::vector<AxisSettings>& axes = rig.positioner.axes;
  std::vector<std::vector<double>> places = rig.capture.stops;
  if (!wish.stops.empty()) {
    if (axes.size() != 1) {
      return Fail(ErrorCode::kBadInput, "--stops: {} has {} axes, the option gives one value a stop", file,
                  axes.size());
    }
    places.clear();
    const double to_si = axes.front().unit == AxisUnit::kRadian ? std::numbers::pi / 180 : 1;
    for (const double value : wish.stops) places.push_back({value * to_si});
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

}  // namespace

Result<PreparedCapture> PrepareCapture(const CaptureWish& wish, const RigFile& rig, const std::string& rig_name) {
  PreparedCapture capture;
  if (rig.cameras.empty()) {
    return Fail(ErrorCode::kBadInput, "{}: has no [[camera]], there is nothing to capture with", rig_name);
  }
  capture.request.subject = wish.subject;
  capture.request.out = wish.out;
  capture.request.resume = wish.resume;
  capture.request.id = std::filesystem::absolute(wish.out / ".").lexically_normal().parent_path().filename();
  const bool arm = rig.model.positioner.kind == PositionerKind::kArm && !rig.positioner.driver.empty();
  if (arm && wish.stops.empty()) {
    capture.request.plan = PlanOfArm(rig.cameras.size());
    capture.request.same_place_rad = rig.positioner.position_tolerance_rad;
    capture.request.same_place_m = rig.positioner.position_tolerance_m;
  } else {
    const Result<std::vector<std::vector<double>>> places = PlacesOf(wish, rig, rig_name);
    if (!places) return Fail(places.error());
    capture.request.plan.stops = PlanOf(*places, rig.cameras.size());
  }
  capture.request.plan.settle_s = rig.positioner.settle_s;
  capture.request.plan.settings = rig.capture;
  capture.hardware = {.cameras = rig.cameras, .positioner = rig.positioner};
  if (rig.sim) capture.hardware.sim = *rig.sim;
  if (rig.replay) capture.hardware.replay = *rig.replay;
  if (rig.board.empty()) return capture;
  const Result<std::string> text = ReadFile(rig.board);
  if (!text) return Fail(text.error());
  Result<Board> board = ParseBoard(*text, rig.board.string());
  if (!board) return Fail(board.error());
  capture.context.board = std::move(*board);
  return capture;
}

Result<CaptureOutcome> CaptureWithDevices(PreparedCapture& capture, Clock& clock,
                                          const std::function<void(const AcquisitionProgress&)>& listener,
                                          const std::stop_token& stop) {
  capture.context.clock = &clock;
  capture.context.subject = capture.request.subject;
  capture.context.open_recording = OpenRecordedPictures;
  const Result<OpenedRig> rig = OpenRig(capture.hardware, capture.context, stop);
  if (!rig) return Fail(rig.error());
  if (rig->real) capture.request.plan.utc_now = UtcNow;
  AcquisitionDevices devices{.positioner = rig->positioner.get(), .clock = &clock};
  for (const auto& camera : rig->cameras) devices.cameras.push_back(camera.get());
  return CaptureRecording(devices, capture.request, listener, stop);
}

std::optional<Subject> SubjectNamed(const std::string& name) {
  for (const Subject subject : {Subject::kChart, Subject::kObject, Subject::kBoth}) {
    if (name == NameOf(subject)) return subject;
  }
  return std::nullopt;
}

}  // namespace rigcal
