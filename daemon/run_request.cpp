#include "daemon/run_request.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/atomic_file.h"
#include "config/rig_report.h"
#include "config/rig_views.h"
#include "core/base/joined.h"
#include "daemon/rig_terms.h"
#include "daemon/run_output.h"

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
      {"poses", run.options.rig ? "rig" : "free"},
      {"camera-from-name", request.pictures.camera_from_name},
      {"masks", request.masks.source},
      {"mask-from-name", request.masks.mask_from_name},
      {"aspect", fmt::format("{}", request.aspect)},
      {"aspect-sigma", fmt::format("{}", request.aspect_sigma)},
      {"fix-cameras", Joined(request.fixed_cameras, ",")},
      {"rounds", fmt::format("{}", request.num_rounds)},
      {"holdout", fmt::format("{}", request.holdout_share)}};
  p.random_seed = request.random_seed;
  for (const std::vector<InputFile>* files : {&run.cameras.files, &run.pictures.files, &run.images.files})
    p.inputs.insert(p.inputs.end(), files->begin(), files->end());
  p.notes = run.cameras.notes;
  return p;
}

/// Whether the file's rig gives the views their poses. Errors: kBadInput for options that contradict each other.
Result<bool> StartsFromRig(const RunRequest& request, const OpenedPictures& pictures, bool has_rig) {
  const bool is_recording = !pictures.recorded.file.name.empty();
  if (request.poses == "rig") {
    if (!is_recording)
      return Fail(ErrorCode::kBadInput, "--poses rig needs a --recording: plain pictures have no stops");
    if (!has_rig)
      return Fail(ErrorCode::kBadInput, "{}: has no rig for --poses rig; `rigcal seed --rig` makes one",
                  request.cameras.string());
    if (!request.fixed_cameras.empty())
      return Fail(ErrorCode::kBadInput, "--fix-cameras needs --poses free: a rig gives the views their poses together");
  }
  const bool starts = has_rig && is_recording && request.poses != "file";
  if (starts && ModeOf(request) == IntrinsicsMode::kPerView)
    return Fail(ErrorCode::kBadInput,
                "{}: its cameras belong to a rig; --intrinsics per-view and --method paper, which "
                "take them apart view by view, need cameras without one",
                request.cameras.string());
  return starts;
}

/// The cameras with a pose for each picture; `terms` are filled when the poses are those of a rig.
Result<LoadedCameras> CamerasFor(const RunRequest& request, const OpenedPictures& pictures,
                                 std::optional<RigTerms>& terms) {
  auto rigged = LoadRiggedCameras(request.cameras);
  if (!rigged) return Fail(rigged.error());
  const Result<bool> starts_from_rig = StartsFromRig(request, pictures, rigged->has_value());
  if (!starts_from_rig) return Fail(starts_from_rig.error());
  if (*starts_from_rig) {
    const RiggedCameras& rig = **rigged;
    auto placed = PlaceRecording(rig.calibration, request.cameras.string(), pictures.recorded.recording,
                                 pictures.folder.string());
    if (!placed) return Fail(placed.error());
    if (request.poses != "free" && request.fixed_cameras.empty()) {
      terms = RigTermsOf(*placed);
      AllowForCreep(*terms);
    }
    LoadedCameras loaded{.calibration = std::move(placed->calibration), .sizes_known = true};
    if (request.poses == "auto" && !request.fixed_cameras.empty())
      loaded.notes.emplace_back("--fix-cameras: the poses are free, not those of the rig");
    loaded.files = {rig.file};
    return loaded;
  }
  CameraFileOptions file = pictures.naming;
  file.intrinsics = ModeOf(request);
  file.allow_skew = request.method == "paper";
  auto cameras = LoadCameras(request.cameras, file);
  if (!cameras) return cameras;
  if (auto complete = CheckAllHaveCameras(pictures.recorded, cameras->calibration, request.cameras); !complete)
    return Fail(complete.error());
  return cameras;
}

}  // namespace

Result<PreparedRun> PrepareRun(const RunRequest& request, RunContext& context) {
  PreparedRun run;
  if (auto masks = request.masks.Check(); !masks) return Fail(masks.error());
  auto pictures = OpenPictures(request.pictures);
  if (!pictures) return Fail(pictures.error());
  run.pictures = std::move(*pictures);

  auto cameras = CamerasFor(request, run.pictures, run.options.rig);
  if (!cameras) return Fail(cameras.error());
  run.cameras = std::move(*cameras);

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

Result<RefinedRig> RefineFiles(const RunRequest& request, RunContext& context) {
  if (auto ready = PrepareResultFolder(request.out, request.cameras); !ready) return Fail(ready.error());
  auto run = PrepareRun(request, context);
  if (!run) return Fail(run.error());
  auto rig = RefineRig(run->images.images, run->cameras.calibration, run->options, context);
  if (!rig) return Fail(rig.error());
  ReportInput(*run, rig->report);
  auto written =
      context.Time("write", -1, [&](const Execution&) { return WriteRunOutput(*rig, run->provenance, request.out); });
  if (written) written = WriteTimingJson(context.Timing(), request.out / "timing.json");
  if (!written) return Fail(written.error());
  return rig;
}

std::string VerdictText(const RunReport& report) {
  const ValidationReport& v = report.validation;
  std::string text = fmt::format("verdict: {}\nheld-out tracks: ", NameOf(v.verdict));
  if (v.holdout.before_px) text += fmt::format("{:.3f} px before, ", *v.holdout.before_px);
  text += fmt::format("{:.3f} px{} ({} tracks)\n", v.holdout.after_px, v.holdout.before_px ? " after" : "",
                      v.holdout.num_tracks);
  for (const Reason& reason : v.reasons) text += "  " + ReasonText(reason) + "\n";
  if (report.rig && report.rig->axis) {
    std::vector<std::string> camera_ids;
    for (const CameraReport& camera : report.cameras) camera_ids.push_back(camera.camera.id);
    text += AxisText(*report.rig->axis, camera_ids);
  }
  for (const std::string& sentence : report.contradictions) text += sentence + "\n";
  return text;
}

}  // namespace rigcal
