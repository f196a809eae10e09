#include "sim_fixtures/studio.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "sim_fixtures/placement.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector3d;

constexpr double kTableThickness_m = 0.012;
constexpr double kTableMargin_m = 0.010;  ///< of table top around the object

tl::unexpected<Error> OutOfRange(std::string_view option, double value, double low, double high) {
  return Fail(ErrorCode::kBadInput, "the simulated studio: {} is {}, must lie within {} .. {}", option, value, low,
              high);
}

struct Range {
  std::string_view option;
  double value, low, high;
};

Result<void> CheckRanges(std::span<const Range> ranges) {
  for (const Range& range : ranges) {
    if (!(range.value >= range.low && range.value <= range.high)) {
      return OutOfRange(range.option, range.value, range.low, range.high);
    }
  }
  return {};
}

Result<void> CheckFaults(const StudioOptions& options) {
  if (options.motion != Motion::kTurntable &&
      !(options.bumps.empty() && options.pixel_bumps.empty() && options.slips.empty())) {
    return Fail(ErrorCode::kBadInput, "the simulated studio: bump and slip are faults of a turntable's rig");
  }
  std::vector<Range> ranges;
  for (const Fault& bump : options.bumps) {
    ranges.push_back({"bump's camera", static_cast<double>(bump.index), 0, options.num_cameras - 1.0});
    ranges.push_back({"bump's angle (deg)", bump.angle_deg, -kMaxBump_deg, kMaxBump_deg});
  }
  for (const PixelBump& bump : options.pixel_bumps) {
    ranges.push_back({"bump's camera", static_cast<double>(bump.index), 0, options.num_cameras - 1.0});
    ranges.push_back({"bump's shift (px)", bump.shift_px, -kMaxPixelBump_px, kMaxPixelBump_px});
  }
  for (const Fault& slip : options.slips) {
    ranges.push_back({"slip's stop", static_cast<double>(slip.index), 0, options.num_stops - 1.0});
    ranges.push_back({"slip's angle (deg)", slip.angle_deg, -kMaxSlip_deg, kMaxSlip_deg});
  }
  return CheckRanges(ranges);
}

Result<void> CheckChart(const ChartOptions& chart) {
  constexpr double kMmPerMetre = 1000;
  const Range ranges[] = {
      {"bow-mm", chart.shape.bow_x_m * kMmPerMetre, -kMaxBow_mm, kMaxBow_mm},
      {"bow-mm", chart.shape.bow_y_m * kMmPerMetre, -kMaxBow_mm, kMaxBow_mm},
      {"board-stretch", chart.shape.stretch, -kMaxStretch, kMaxStretch},
      {"board-tilt-deg", chart.tilt_deg, -kMaxBoardTilt_deg, kMaxBoardTilt_deg},
      {"hand-held", static_cast<double>(chart.num_hand_held), 0, kMaxHandHeld},
  };
  return CheckRanges(ranges);
}

Result<void> Check(const StudioOptions& options) {
  const bool turns = options.motion == Motion::kTurntable;
  const Range ranges[] = {
      {"cameras", static_cast<double>(options.num_cameras), 1, turns ? 1.0 * kMaxCameras : 1.0},
      {"stops", static_cast<double>(turns ? options.num_stops : 1), 1, kMaxViews},
      {"views", static_cast<double>(turns ? 1 : options.num_views), 1, kMaxViews},
      {"width", static_cast<double>(options.width_px), kMinSide_px, kMaxSide_px},
      {"height", static_cast<double>(options.height_px), kMinSide_px, kMaxSide_px},
      {"step-error-deg", options.step_error_deg, 0, kMaxStepError_deg},
      {"wobble-deg", options.wobble_deg, 0, turns ? kMaxWobble_deg : 0.0},
      {"run-out-mm", options.run_out_mm, 0, turns ? kMaxRunOut_mm : 0.0},
      {"object-variant", static_cast<double>(options.object_variant), 0, kMaxObjectVariant},
      {"cell (m)", options.cell_m, 0.0003, 0.01},
  };
  if (const auto checked = CheckRanges(ranges); !checked) return checked;
  if (const auto checked = CheckFaults(options); !checked) return checked;
  return options.chart ? CheckChart(*options.chart) : Result<void>();
}

/// A distortion that cannot be inverted at the corners of the picture has no rays there.
Result<void> CheckDistortion(const Camera& camera) {
  for (const double u : {-0.5, camera.width_px - 0.5}) {
    for (const double v : {-0.5, camera.height_px - 0.5}) {
      if (!RayInCam(camera, {u, v})) {
        return Fail(ErrorCode::kBadInput,
                    "the simulated studio: distortion k1 = {} k2 = {} k3 = {} folds over within the picture", camera.k1,
                    camera.k2, camera.k3);
      }
    }
  }
  return {};
}

/// The smallest table top with a margin round what stands on it.
double TableRadius_m(const TriangleMesh& mesh) {
  double radius_m = 0;
  for (const Eigen::Vector3f& x : mesh.vertices_in_world) {
    radius_m = std::max(radius_m, static_cast<double>(std::hypot(x.x(), x.y())));
  }
  return radius_m + kTableMargin_m;
}

/// The board instead of the object.
Chart LayChart(const StudioOptions& options, const std::vector<Camera>& cameras, std::vector<TriangleMesh>& meshes) {
  const Rigid3d world_from_board = PlaceChart(*options.chart, options.random_seed);
  meshes[kObjectMesh] = ChartMesh(*options.chart, world_from_board);
  return {.world_from_board = world_from_board,
          .material = ChartMaterial(*options.chart, world_from_board),
          .hand_held = HoldByHand(*options.chart, cameras, options.random_seed),
          .rays_in_hand = RayScene(std::vector<TriangleMesh>{meshes[kObjectMesh]})};
}

void LightStudio(Studio& studio) {
  studio.ambient = 0.28;
  studio.lights = {{Vector3d(-0.55, -0.65, 0.62).normalized(), 0.52, 0.25},
                   {Vector3d(0.85, -0.35, 0.25).normalized(), 0.22, 0.45},
                   {Vector3d(0.10, 0.90, 0.45).normalized(), 0.24, 0.35}};
  studio.table_top = {
      .texture = {.longest_m = 0.020f, .num_octaves = 5, .gain = 0.8f, .seed = 50}, .mean = 0.42f, .contrast = 0.12f};
  studio.walls = {
      .texture = {.longest_m = 0.15f, .num_octaves = 6, .gain = 0.75f, .seed = 70}, .mean = 0.25f, .contrast = 0.09f};
}

template <typename Kind, std::size_t n>
std::optional<Kind> Find(const std::array<std::pair<std::string_view, Kind>, n>& names, std::string_view name) {
  for (const auto& [known, kind] : names) {
    if (known == name) return kind;
  }
  return std::nullopt;
}

template <typename Kind, std::size_t n>
std::string_view NameIn(const std::array<std::pair<std::string_view, Kind>, n>& names, Kind kind) {
  for (const auto& [name, known] : names) {
    if (known == kind) return name;
  }
  return "";
}

constexpr std::array<std::pair<std::string_view, Motion>, 2> kMotions = {
    {{"turntable", Motion::kTurntable}, {"gantry", Motion::kGantry}}};
constexpr std::array<std::pair<std::string_view, Surroundings>, 2> kSurroundings = {
    {{"black", Surroundings::kBlack}, {"backdrop", Surroundings::kBackdrop}}};

}  // namespace

std::optional<Motion> MotionFromName(std::string_view name) {
  return Find(kMotions, name);
}
std::string_view NameOf(Motion motion) {
  return NameIn(kMotions, motion);
}
std::optional<Surroundings> SurroundingsFromName(std::string_view name) {
  return Find(kSurroundings, name);
}
std::string_view NameOf(Surroundings surroundings) {
  return NameIn(kSurroundings, surroundings);
}

Result<Studio> MakeStudio(const StudioOptions& options, const Execution& execution) {
  if (const auto checked = Check(options); !checked) return Fail(checked.error());
  std::vector<TriangleMesh> meshes = {MeshOf(ShapeOf(options.scene), options.cell_m, execution)};
  if (execution.Stopped()) return Cancelled("the simulated studio");
  Placement placement = PlaceCameras(options, meshes[kObjectMesh].vertices_in_world);
  const Scene object = options.object.value_or(options.scene);
  if (object != options.scene || options.object_variant != 0) {
    meshes[kObjectMesh] = MeshOf(VariantOf(ShapeOf(object), options.object_variant), options.cell_m, execution);
    if (execution.Stopped()) return Cancelled("the simulated studio");
  }
  for (const Camera& camera : placement.truth.cameras) {
    if (const auto checked = CheckDistortion(camera); !checked) return Fail(checked.error());
  }
  std::optional<Chart> chart;
  if (options.chart) chart = LayChart(options, placement.truth.cameras, meshes);
  double table_radius_m = 0;
  if (options.surroundings == Surroundings::kBackdrop) {
    table_radius_m = TableRadius_m(meshes[kObjectMesh]);
    meshes.push_back(DiscMesh(table_radius_m, kTableThickness_m));
  }
  Studio studio{.options = options,
                .truth = std::move(placement.truth),
                .stage_from_world = std::move(placement.stage_from_world),
                .table_angle_rad = std::move(placement.table_angle_rad),
                .stop = std::move(placement.stop),
                .commanded_rad = std::move(placement.commanded_rad),
                .stop_errors = std::move(placement.stop_errors),
                .cam_from_stage = std::move(placement.cam_from_stage),
                .lights = {},
                .ambient = 0,
                .object = VariantOf(MaterialOf(object), options.object_variant),
                .table_top = {},
                .walls = {},
                .table_radius_m = table_radius_m,
                .chart = std::move(chart),
                .rays = RayScene(std::move(meshes))};
  LightStudio(studio);
  return studio;
}

}  // namespace rigcal::sim
