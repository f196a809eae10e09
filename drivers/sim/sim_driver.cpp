#include "drivers/sim/sim_driver.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "core/base/ensure.h"
#include "core/seed/tag_family.h"
#include "drivers/sim/sim_camera.h"
#include "drivers/sim/sim_positioner.h"

namespace rigcal {
namespace {

constexpr const char* kName = "sim";

Result<sim::ChartOptions> ChartOf(const std::optional<Board>& board) {
  if (!board) return Fail(ErrorCode::kBadInput, "sim: a chart is to be seen, but the rig names no board");
  const Result<TagFamily> family = TagFamily::Make(board->family, board->border_bits);
  if (!family) return Fail(family.error());
  sim::ChartOptions chart{.print = {*board, family->EdgeCells(), {}}};
  for (int id = board->first_id; id < board->first_id + board->NumTags(); ++id) {
    chart.print.cells.push_back(family->Cells(id));
  }
  return chart;
}

/// The settings as the studio has them. A single stop: views elsewhere are made when they are asked for.
Result<sim::StudioOptions> StudioOptionsOf(const SimSettings& settings, const DriverContext& context) {
  constexpr double kDegPerRad = 180 / std::numbers::pi, kMmPerMetre = 1e3;
  const auto scene = sim::SceneFromName(settings.scene);
  if (!scene) return Fail(ErrorCode::kBadInput, "sim: there is no scene '{}'", settings.scene);
  const auto surroundings = sim::SurroundingsFromName(settings.surroundings);
  if (!surroundings) return Fail(ErrorCode::kBadInput, "sim: there are no surroundings '{}'", settings.surroundings);
  sim::StudioOptions options{.scene = *scene,
                             .surroundings = *surroundings,
                             .num_cameras = settings.num_cameras,
                             .num_stops = 1,
                             .width_px = settings.width_px,
                             .height_px = settings.height_px,
                             .step_error_deg = settings.step_error_rad * kDegPerRad,
                             .wobble_deg = settings.wobble_rad * kDegPerRad,
                             .run_out_mm = settings.run_out_m * kMmPerMetre,
                             .random_seed = settings.random_seed};
  if (context.subject != Subject::kChart) return options;
  Result<sim::ChartOptions> chart = ChartOf(context.board);
  if (!chart) return Fail(chart.error());
  options.chart = std::move(*chart);
  return options;
}

class SimDriver final : public Driver {
 public:
  SimDriver(std::shared_ptr<SimRig> sim, const RigHardware& rig) : sim_(std::move(sim)) {
    for (const CameraSettings& camera : rig.cameras) {
      if (camera.driver == kName) ids_.push_back(camera.id);
    }
  }

  Result<std::unique_ptr<CameraDevice>> OpenCamera(const CameraSettings& settings,
                                                   const std::stop_token& /*stop*/) override {
    const auto id = std::ranges::find(ids_, settings.id);
    Ensure(id != ids_.end(), "a camera that is opened is one of the rig's");
    return SimCamera::Open(sim_, static_cast<int>(id - ids_.begin()), settings);
  }

  Result<std::unique_ptr<PositionerDevice>> OpenPositioner(const PositionerSettings& settings,
                                                           const std::stop_token& /*stop*/) override {
    return SimPositioner::Open(sim_, settings);
  }

 private:
  std::shared_ptr<SimRig> sim_;
  std::vector<std::string> ids_;
};

}  // namespace

Result<std::shared_ptr<SimRig>> MakeSimRig(const RigHardware& rig, const DriverContext& context,
                                           const std::stop_token& stop) {
  Ensure(context.clock != nullptr, "a simulated studio needs a clock");
  const Result<sim::StudioOptions> options = StudioOptionsOf(rig.sim, context);
  if (!options) return Fail(options.error());
  Result<sim::Studio> studio = sim::MakeStudio(*options, {.stop = stop});
  if (!studio) return Fail(studio.error());
  sim::ShotOptions shot;
  shot.sensor.linear = true;  // as machine-vision cameras are
  shot.sensor.blur_sigma_px = rig.sim.blur_sigma_px;
  shot.sensor.noise_sigma = rig.sim.noise_sigma;
  return std::make_shared<SimRig>(std::move(*studio), shot, *context.clock);
}

std::unique_ptr<Driver> DriverOf(std::shared_ptr<SimRig> sim, const RigHardware& rig) {
  return std::make_unique<SimDriver>(std::move(sim), rig);
}

Result<std::unique_ptr<Driver>> MakeSimDriver(const RigHardware& rig, const DriverContext& context,
                                              const std::stop_token& stop) {
  Result<std::shared_ptr<SimRig>> sim = MakeSimRig(rig, context, stop);
  if (!sim) return Fail(sim.error());
  return DriverOf(std::move(*sim), rig);
}

}  // namespace rigcal
