#include "daemon/cli/sim_recording.h"

#include "config/atomic_file.h"
#include "config/read_file.h"
#include "config/recording_file.h"

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

}  // namespace

Result<void> WriteSimRecording(const sim::Studio& studio, const sim::ShotOptions& shot,
                               const std::filesystem::path& folder) {
  const sim::StudioOptions& options = studio.options;
  Recording recording{
      .id = fmt::format("sim-{}-{}-{}", sim::NameOf(options.scene), sim::NameOf(options.motion), options.random_seed),
      .closed = true,
      .linear = shot.sensor.linear};
  for (const Camera& camera : studio.truth.cameras)
    recording.cameras.push_back({.id = camera.id, .width_px = camera.width_px, .height_px = camera.height_px});
  for (int v = 0; v < studio.truth.NumViews(); ++v) {
    const View& view = studio.truth.views[v];
    const int stop = studio.stop[v];
    if (stop == static_cast<int>(recording.stops.size())) recording.stops.push_back(StopOf(studio, stop, v));
    const Result<std::string> bytes = ReadFile(folder / view.name);
    if (!bytes) return Fail(bytes.error());
    recording.views.push_back({.file = view.name, .camera = view.camera, .stop = stop, .sha256 = Sha256Hex(*bytes)});
  }
  return WriteFileAtomically(folder / kRecordingFile, RecordingText(recording));
}

}  // namespace rigcal
