#pragma once

#include <filesystem>
#include <vector>

#include "sim_fixtures/disturb.h"
#include "sim_fixtures/render.h"
#include "sim_fixtures/studio.h"

namespace rigcal::sim {

struct FolderOptions {
  SensorOptions sensor;
  int samples_per_side = 3;
  std::vector<double> disturb_px = {6, 12};  ///< a start_<E>px_par.txt for each
  int num_points = 3000;
};

/// Limits, named in messages.
inline constexpr int kMaxSamplesPerSide = 8;
inline constexpr double kMaxBlur_px = 5, kMaxNoise = 64, kMaxDisturbance_px = 100;

/// Renders every view of the studio into a folder (made when it is not there), each file whole or not at all:
///   <view>.png, masks/<view>.png (255: object, and table top where there is one), truth_par.txt (Middlebury),
///   truth.json (everything that is needed to make the same studio again, and the cameras), points.txt
///   (x y z k v1 .. vk), start_<E>px_par.txt (disturbed cameras).
/// With distortion the *_par.txt hold the cameras of undistorted pictures.
Result<void> WriteImageFolder(const Studio& studio, const FolderOptions& options, const std::filesystem::path& folder,
                              const Execution& execution);

/// The studio of a folder that WriteImageFolder wrote. Errors: kNotFound, kBadInput (also when this version of the
/// studio puts its cameras elsewhere than truth.json says).
Result<Studio> ReadStudio(const std::filesystem::path& folder, const Execution& execution);

}  // namespace rigcal::sim
