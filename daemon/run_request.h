#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "config/load_cameras.h"
#include "config/load_images.h"
#include "config/provenance.h"
#include "daemon/calibration_run.h"
#include "daemon/mask_request.h"
#include "daemon/picture_source.h"

namespace rigcal {

/// What `refine` and `validate` are asked for, on the command line or by a job.
struct RunRequest {
  PictureSource pictures;
  std::filesystem::path cameras;
  std::filesystem::path out;    ///< refine only
  std::filesystem::path prior;  ///< validate only; empty: none
  std::optional<double> expected_error_px;
  MaskRequest masks;
  std::string intrinsics = "per-camera";
  double aspect = CameraPrior{}.aspect;
  double aspect_sigma = CameraPrior{}.aspect_sigma;
  std::vector<std::string> fixed_cameras;
  /// rig: as the cameras' rig gives them; free: those are a start; auto: rig where there is one and pictures have
  /// stops; file: as the camera file has them, by the pictures' names
  std::string poses = "auto";
  std::string method = "rigcal";
  int num_rounds = RefineOptions{}.num_rounds;
  double holdout_share = RefineOptions{}.holdout_share;
  std::uint64_t random_seed = RefineOptions{}.random_seed;
  int num_threads = 0;  ///< 0: one for each processor
  bool json = false;
};

/// Everything that a run needs, read and checked.
struct PreparedRun {
  OpenedPictures pictures;
  LoadedCameras cameras;
  LoadedImages images;
  RefineOptions options;
  Provenance provenance;
};

/// Reads cameras and pictures. Errors: those of OpenPictures, LoadCameras and LoadImages; kNotFound for a camera to be
/// fixed that does not exist.
Result<PreparedRun> PrepareRun(const RunRequest& request, RunContext& context);

/// Completes a report with what was learnt while reading.
void ReportInput(const PreparedRun& run, RunReport& report);

/// The whole of `rigcal refine`, and of a job that refines: pictures and cameras in, a result folder out
/// (`request.out`: see WriteRunOutput, and timing.json). Errors: those of PrepareResultFolder, PrepareRun, RefineRig
/// and WriteRunOutput.
Result<RefinedRig> RefineFiles(const RunRequest& request, RunContext& context);

/// The verdict in a few lines, for people.
std::string VerdictText(const RunReport& report);

}  // namespace rigcal
