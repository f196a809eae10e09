#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "daemon/cli/command.h"
#include "daemon/cli/number_options.h"
#include "daemon/cli/sim_chart_options.h"
#include "daemon/cli/sim_commands.h"
#include "daemon/cli/sim_folder.h"
#include "daemon/run_context.h"

namespace rigcal {
namespace {

struct RenderRequest {
  sim::StudioOptions studio;
  SimFolderOptions folder;
  SimChartRequest chart;
  std::vector<std::string> bumps, pixel_bumps, slips;
  std::string scene = "textured", object, motion = "turntable", background = "black";
  std::vector<double> distortion;
  std::string out;
  int num_threads = 0;  ///< 0: one for each processor
};

template <typename Kind>
Result<Kind> Choose(std::optional<Kind> found, std::string_view option, const std::string& given,
                    const std::vector<std::string>& allowed) {
  if (found) return *found;
  return Fail(ErrorCode::kBadInput, "--{} is '{}', must be one of: {}", option, given, fmt::join(allowed, ", "));
}

Result<void> Complete(RenderRequest& request) {
  const auto scene = Choose(sim::SceneFromName(request.scene), "scene", request.scene, sim::SceneNames());
  if (!scene) return Fail(scene.error());
  const auto motion = Choose(sim::MotionFromName(request.motion), "motion", request.motion, {"turntable", "gantry"});
  if (!motion) return Fail(motion.error());
  const auto surroundings =
      Choose(sim::SurroundingsFromName(request.background), "background", request.background, {"black", "backdrop"});
  if (!surroundings) return Fail(surroundings.error());
  request.studio.scene = *scene;
  if (!request.object.empty()) {
    const auto object = Choose(sim::SceneFromName(request.object), "object", request.object, sim::SceneNames());
    if (!object) return Fail(object.error());
    request.studio.object = *object;
  }
  request.studio.motion = *motion;
  request.studio.surroundings = *surroundings;
  if (request.distortion.size() > request.studio.distortion.size()) {
    return Fail(ErrorCode::kBadInput, "--distortion has {} values, at most {} are known (k1,k2,p1,p2,k3)",
                request.distortion.size(), request.studio.distortion.size());
  }
  std::copy(request.distortion.begin(), request.distortion.end(), request.studio.distortion.begin());
  return {};
}

Result<void> CompleteRig(RenderRequest& request) {
  const auto bumps = FaultsOf({"bump", "cam", "an angle in degrees"}, request.bumps);
  if (!bumps) return Fail(bumps.error());
  const auto pixel_bumps = FaultsOf({"bump-px", "cam", "pixels"}, request.pixel_bumps);
  if (!pixel_bumps) return Fail(pixel_bumps.error());
  const auto slips = FaultsOf({"slip", "", "an angle in degrees"}, request.slips);
  if (!slips) return Fail(slips.error());
  auto chart = ChartOf(request.chart);
  if (!chart) return Fail(chart.error());
  for (const auto& [camera, angle_deg] : *bumps) request.studio.bumps.push_back({camera, angle_deg});
  for (const auto& [camera, shift_px] : *pixel_bumps) request.studio.pixel_bumps.push_back({camera, shift_px});
  for (const auto& [stop, angle_deg] : *slips) request.studio.slips.push_back({stop, angle_deg});
  request.studio.chart = std::move(*chart);
  return {};
}

/// How far the rig's stops are off, and faults that nothing in the recording tells.
void AddRigErrorOptions(CLI::App& command, RenderRequest& request) {
  sim::StudioOptions& studio = request.studio;
  command.add_option("--step-error-deg", studio.step_error_deg, "Standard deviation of the table's angles")
      ->capture_default_str();
  command
      .add_option("--wobble-deg", studio.wobble_deg, "Standard deviation of the table's tilt, about each of x and y")
      ->capture_default_str();
  command.add_option("--run-out-mm", studio.run_out_mm, "Standard deviation of its shift, along each of x and y")
      ->capture_default_str();
  command.add_option("--bump", request.bumps, "CAMERA:DEG, a fault: this camera is turned by DEG about a random axis")
      ->take_all();
  command
      .add_option("--bump-px", request.pixel_bumps,
                  "CAMERA:PX, a fault: turned so far that the object's pictures move by PX on average")
      ->take_all();
  command.add_option("--slip", request.slips, "STOP:DEG, a fault: at this stop the table has turned DEG too far")
      ->take_all();
}

Result<void> Render(RenderRequest& request, const CommandSession& session) {
  if (auto completed = Complete(request); !completed) return completed;
  if (auto completed = CompleteRig(request); !completed) return completed;
  Execution execution{.stop = session.stop, .num_threads = NumThreads(request.num_threads), .report_progress = {}};
  if (session.on_terminal) {
    execution.report_progress = [](double share) { fmt::print(stderr, "\rrender {:3.0f} %", 100 * share); };
  }
  const auto studio = sim::MakeStudio(request.studio, execution);
  if (!studio) return Fail(studio.error());
  auto written = WriteSimFolder(*studio, request.folder, request.out, execution);
  if (session.on_terminal) fmt::print(stderr, "\n");
  const std::size_t num_held = studio->chart ? studio->chart->hand_held.size() : 0;
  if (written) fmt::print("{} pictures in {}\n", studio->truth.views.size() + num_held, request.out);
  return written;
}

}  // namespace

void AddSimRenderCommand(CLI::App& sim, CommandSession& session) {
  CLI::App* command = sim.add_subcommand("render", "Renders a set of pictures with exact truth");
  const auto request = std::make_shared<RenderRequest>();
  sim::StudioOptions& studio = request->studio;
  SimFolderOptions& folder = request->folder;
  command->add_option("--out", request->out, "Folder to write")->required();
  command->add_option("--scene", request->scene, "textured, plaster or thin")->capture_default_str();
  command->add_option("--object", request->object, "The object of this scene on the table, under the scene's cameras");
  command
      ->add_option("--object-variant", studio.object_variant,
                   "Above 0: another object of its kind, with another texture and turned about the axis")
      ->capture_default_str();
  command->add_option("--motion", request->motion, "turntable or gantry")->capture_default_str();
  command->add_option("--background", request->background, "black or backdrop")->capture_default_str();
  command->add_option("--cameras", studio.num_cameras, "Cameras at a turntable")->capture_default_str();
  command->add_option("--stops", studio.num_stops, "Stops of a turntable")->capture_default_str();
  command->add_option("--views", studio.num_views, "Views of a gantry")->capture_default_str();
  command->add_option("--width", studio.width_px, "Pixels")->capture_default_str();
  command->add_option("--height", studio.height_px, "Pixels")->capture_default_str();
  command->add_option("--distortion", request->distortion, "Brown coefficients k1,k2,p1,p2,k3")->delimiter(',');
  AddRigErrorOptions(*command, *request);
  AddSimChartOptions(*command, request->chart);
  command->add_option("--samples", folder.shot.samples_per_side, "Samples along a pixel's side")->capture_default_str();
  command->add_option("--blur-px", folder.shot.sensor.blur_sigma_px, "Sigma of the lens")->capture_default_str();
  command->add_option("--noise", folder.shot.sensor.noise_sigma, "Sigma in grey levels of 8 bit")
      ->capture_default_str();
  command->add_flag("--linear", folder.shot.sensor.linear, "Values proportional to the light, no sRGB curve");
  command->add_option("--bits", folder.shot.sensor.bits, "8 or 16")->capture_default_str();
  command->add_option("--disturb-px", folder.disturb_px, "Mean errors of the disturbed starts")
      ->delimiter(',')
      ->capture_default_str();
  command->add_flag("--recording", folder.recording,
                    "Also write recording.json: the folder is a recording; and rig.toml, of a turntable");
  command->add_option("--random-seed", studio.random_seed, "Of noise, errors of the rig, starts and how a chart lies")
      ->capture_default_str();
  AddThreadsOption(*command, request->num_threads);
  command->callback([request, &session] {
    const Result<void> rendered = Render(*request, session);
    session.exit_status = rendered ? kExitAccepted : FailWith("sim render", rendered.error());
  });
}

}  // namespace rigcal
