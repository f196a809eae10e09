#include "daemon/cli/sim_recording.h"

#include <numbers>

#include "config/atomic_file.h"
#include "config/read_file.h"
#include "config/recording_file.h"
#include "config/rig_file.h"

namespace rigcal {
namespace {

RecordedStop StopOf(const sim::Studio& studio, int stop, int view) {
  RecordedStop recorded{.id = fmt::format("{:02}", stop)};
  if (studio.options.motion == sim::Motion::kTurntable) {
    recorded.axes.push_back({.axis = kTableAxis, .unit = AxisUnit::kRadian, .commanded = studio.commanded_rad[stop]});
  } else {
    recorded.base_from_flange_commanded = studio.truth.views[view].cam_from_world.Inverse();
  }
  return recorded;
}

RigFile RigOf(const sim::StudioOptions& options) {
  constexpr double kRadPerDeg = std::numbers::pi / 180, kMetrePerMm = 1e-3;
  RigFile rig{Turntable(), {kTableAxis}};
  StopError& sigma = rig.model.error_sigma;
  if (options.step_error_deg > 0) sigma[kStep] = options.step_error_deg * kRadPerDeg;
  if (options.wobble_deg > 0) sigma[kWobbleX] = sigma[kWobbleY] = options.wobble_deg * kRadPerDeg;
  if (options.run_out_mm > 0) sigma[kRunOutX] = sigma[kRunOutY] = options.run_out_mm * kMetrePerMm;
  return rig;
}

}  // namespace

Result<void> WriteSimRecording(const sim::Studio& studio, const sim::ShotOptions& shot,
                               const std::filesystem::path& folder) {
  const sim::StudioOptions& options = studio.options;
  Recording recording{.id = fmt::format("sim-{}-{}-{}", studio.chart ? "chart" : sim::NameOf(options.scene),
                                        sim::NameOf(options.motion), options.random_seed),
                      .closed = true,
                      .linear = shot.sensor.linear};
  for (const Camera& camera : studio.truth.cameras)
    recording.cameras.push_back({.id = camera.id, .width_px = camera.width_px, .height_px = camera.height_px});
  const Subject subject = studio.chart ? Subject::kChart : Subject::kObject;
  const auto add = [&](const std::string& file, int camera, std::optional<int> stop) -> Result<void> {
    const Result<std::string> bytes = ReadFile(folder / file);
    if (!bytes) return Fail(bytes.error());
    recording.views.push_back(
        {.file = file, .camera = camera, .stop = stop, .subject = subject, .sha256 = Sha256Hex(*bytes)});
    return {};
  };
  for (int v = 0; v < studio.truth.NumViews(); ++v) {
    const View& view = studio.truth.views[v];
    const int stop = studio.stop[v];
    if (stop == static_cast<int>(recording.stops.size())) recording.stops.push_back(StopOf(studio, stop, v));
    if (const Result<void> added = add(view.name, view.camera, stop); !added) return added;
  }
  for (const sim::HandHeldView& view : studio.chart ? studio.chart->hand_held : std::vector<sim::HandHeldView>()) {
    if (const Result<void> added = add(view.name, view.camera, std::nullopt); !added) return added;
  }
  if (options.motion == sim::Motion::kTurntable) {
    const Result<void> written = WriteFileAtomically(folder / kRigFile, RigText(RigOf(options)));
    if (!written) return written;
  }
  return WriteFileAtomically(folder / kRecordingFile, RecordingText(recording));
}

}  // namespace rigcal
