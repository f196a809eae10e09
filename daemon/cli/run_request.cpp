#include "daemon/cli/run_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "daemon/cli/number_options.h"

namespace rigcal {
namespace {

/// Pyramids reach level 4: Er up to 31 px (paper, Table 1: L = floor(log2 Er)).
constexpr int kPyramidLevels = 5;
/// Patches are coloured from pictures of this level, where a patch is about a pixel.
constexpr int kColourLevel = 2;

IntrinsicsMode ModeOf(const RunRequest& request) {
  if (request.method == "paper" || request.intrinsics == "per-view") return IntrinsicsMode::kPerView;
  return request.intrinsics == "fixed" ? IntrinsicsMode::kFixed : IntrinsicsMode::kPerCamera;
}

std::vector<CameraPrior> CameraPriors(const RunRequest& request, const RigCalibration& seed) {
  std::vector<CameraPrior> priors;
  for (const Camera& camera : seed.cameras) {
    priors.push_back({.aspect = request.aspect,
                      .aspect_sigma = request.aspect_sigma,
                      .principal_point_px = {camera.cx_px, camera.cy_px}});
  }
  return priors;
}

Result<std::vector<bool>> FixedViews(const std::vector<std::string>& ids, const RigCalibration& seed) {
  std::vector<bool> fixed(seed.views.size(), false);
  for (const std::string& id : ids) {
    bool found = false;
    for (int v = 0; v < seed.NumViews(); ++v) {
      const Camera& camera = seed.CameraOf(v);
      if (camera.id != id && camera.physical_id != id && seed.views[v].name != id) continue;
      found = fixed[v] = true;
    }
    if (!found) {
      std::string known;
      for (const Camera& camera : seed.cameras) known += (known.empty() ? "" : ", ") + camera.id;
      return Fail(ErrorCode::kNotFound, "--fix-cameras: there is no camera or view '{}'; the cameras are {}", id,
                  known);
    }
  }
  if (std::ranges::find(fixed, false) == fixed.end()) {
    return Fail(ErrorCode::kBadInput, "--fix-cameras: all {} views are fixed, nothing is left to refine", fixed.size());
  }
  return ids.empty() ? std::vector<bool>{} : fixed;
}

Provenance ProvenanceOf(const RunRequest& request, const PreparedRun& run) {
  Provenance p{.program_version = std::string(ProgramVersion()), .method = request.method};
  p.options = {
      {"expected-error-px", request.expected_error_px ? fmt::format("{}", *request.expected_error_px) : "auto"},
      {"intrinsics", request.intrinsics},
      {"camera-from-name", request.pictures.camera_from_name},
      {"masks", request.masks.source},
      {"mask-from-name", request.masks.mask_from_name},
      {"aspect", fmt::format("{}", request.aspect)},
      {"aspect-sigma", fmt::format("{}", request.aspect_sigma)},
      {"fix-cameras", fmt::format("{}", fmt::join(request.fixed_cameras, ","))},
      {"rounds", fmt::format("{}", request.num_rounds)},
      {"holdout", fmt::format("{}", request.holdout_share)}};
  p.random_seed = request.random_seed;
  for (const std::vector<InputFile>* files : {&run.cameras.files, &run.pictures.files, &run.images.files})
    p.inputs.insert(p.inputs.end(), files->begin(), files->end());
  p.notes = run.cameras.notes;
  return p;
}

}  // namespace

void AddRunOptions(CLI::App& command, RunRequest& request) {
  AddPictureOptions(command, request.pictures);
  command
      .add_option("--cameras", request.cameras, "Cameras: Middlebury *_par.txt, COLMAP text model or calibration.json")
      ->required();
  command
      .add_option("--expected-error-px", request.expected_error_px,
                  "Er: how many pixels the cameras may be off; estimated from the photographs when absent")
      ->check(NumberWithin(0.1, 31.0));
  AddMaskOptions(command, request.masks);
  command.add_option("--aspect", request.aspect, "fx / fy of every camera")->check(NumberWithin(0.5, 2.0));
  command.add_option("--aspect-sigma", request.aspect_sigma, "How sure that is (1 sigma)")
      ->check(NumberWithin(1e-6, 1.0));
  command.add_option("--random-seed", request.random_seed, "Seed of every random choice");
  AddThreadsOption(command, request.num_threads);
  command.add_flag("--json", request.json, "Print the report as JSON");
}

Result<PreparedRun> PrepareRun(const RunRequest& request, RunContext& context) {
  PreparedRun run;
  if (auto masks = request.masks.Check(); !masks) return Fail(masks.error());
  auto pictures = OpenPictures(request.pictures);
  if (!pictures) return Fail(pictures.error());
  run.pictures = std::move(*pictures);

  CameraFileOptions file = run.pictures.naming;
  file.intrinsics = ModeOf(request);
  file.allow_skew = request.method == "paper";
  auto cameras = LoadCameras(request.cameras, file);
  if (!cameras) return Fail(cameras.error());
  run.cameras = std::move(*cameras);
  if (auto complete = CheckAllHaveCameras(run.pictures.recorded, run.cameras.calibration, request.cameras); !complete)
    return Fail(complete.error());

  ImageOptions options{.num_levels = kPyramidLevels, .colour_level = kColourLevel};
  options.masks = request.masks.Source();
  options.mask_folder = request.masks.Folder();
  options.mask_from_name = request.masks.mask_from_name;
  options.sha256_by_image = run.pictures.recorded.sha256_by_image;
  auto images = context.Time("load", -1, [&](const Execution& execution) {
    return LoadImages(run.pictures.folder, run.cameras.calibration, options, execution);
  });
  if (!images) return Fail(images.error());
  run.images = std::move(*images);

  auto fixed = FixedViews(request.fixed_cameras, run.cameras.calibration);
  if (!fixed) return Fail(fixed.error());
  run.options.method = request.method == "paper" ? RefineMethod::kPaper : RefineMethod::kRigcal;
  run.options.expected_error_px = request.expected_error_px;
  run.options.num_rounds = request.num_rounds;
  run.options.intrinsics = ModeOf(request);
  run.options.camera_priors = CameraPriors(request, run.cameras.calibration);
  run.options.fixed_views = std::move(*fixed);
  run.options.holdout_share = request.holdout_share;
  run.options.random_seed = request.random_seed;
  run.provenance = ProvenanceOf(request, run);
  return run;
}

void ReportInput(const PreparedRun& run, RunReport& report) {
  report.notes.insert(report.notes.begin(), run.cameras.notes.begin(), run.cameras.notes.end());
  for (int v = 0; v < run.images.images.NumViews(); ++v) {
    report.masks.push_back(
        {run.cameras.calibration.views[v].name, NameOf(run.images.mask_kind[v]), run.images.object_share[v]});
  }
}

std::string VerdictText(const RunReport& report) {
  const ValidationReport& v = report.validation;
  std::string text = fmt::format("verdict: {}\nheld-out tracks: {:.3f} px before, {:.3f} px after ({} tracks)\n",
                                 NameOf(v.verdict), v.holdout.before_px, v.holdout.after_px, v.holdout.num_tracks);
  for (const Reason& reason : v.reasons) {
    text +=
        fmt::format("  {}{}: {:.4g} {} against a limit of {:.4g} {}\n", reason.check,
                    reason.view ? " (" + *reason.view + ")" : "", reason.value, reason.unit, reason.limit, reason.unit);
  }
  return text;
}

int FailWith(const char* command, const Error& error) {
  fmt::print(stderr, "rigcal {}: {}\n", command, error.message);
  return error.code == ErrorCode::kCancelled ? kExitInternal : kExitBadInput;
}

}  // namespace rigcal
