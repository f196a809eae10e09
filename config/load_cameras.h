#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "config/read_file.h"
#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

struct CameraFileOptions {
  /// Searched in each image's file name; its first group is the id of the physical camera. Empty: what the file says;
  /// a file that says nothing (Middlebury) has one camera.
  std::string camera_from_name;
  /// Instead of camera_from_name: the id of the physical camera by image name, as a recording has it. Empty: unknown.
  std::map<std::string, std::string> camera_by_image;
  /// kPerView gives each view a Camera of its own, "<physical>/<image>"; the others share one Camera among the views of
  /// a physical camera, which starts from the median of each parameter.
  IntrinsicsMode intrinsics = IntrinsicsMode::kPerCamera;
  bool allow_skew = false;  ///< otherwise |skew| above kMaxIgnoredSkewPx is refused and below is set to 0
  int min_views = 3;
};

/// Skew (k12 of a Middlebury file, pixels) that is taken for rounding.
inline constexpr double kMaxIgnoredSkewPx = 0.01;

struct LoadedCameras {
  RigCalibration calibration;
  bool sizes_known = false;  ///< false: the file does not tell width and height (Middlebury); LoadImages fills them in
  std::vector<std::string> notes;  ///< sentences for the report: what was changed while loading
  bool intrinsics_differ = false;  ///< views that share a Camera came with differing intrinsics
  /// Largest difference of any view's fx, fy, cx or cy from its camera's median (pixels); 0 with kPerView.
  double max_intrinsics_spread_px = 0;
  std::vector<InputFile> files;
};

/// Reads cameras from a Middlebury *_par.txt, a COLMAP text model (a folder with cameras.txt and images.txt) or a
/// calibration.json, told apart by their content (docs/formats.md). Views keep the order of the file. Errors:
/// kNotFound, kIo, kBadInput, kUnsupported.
Result<LoadedCameras> LoadCameras(const std::filesystem::path& path, const CameraFileOptions& options);

/// The same without changing any number: views share a Camera only where the file gives them the same one. Skew and any
/// number of views are allowed. Of the options only those that name the cameras count; without them a calibration.json
/// is taken as it stands, with cameras that have no view, covariance and rig. For comparing, exporting and stereo.
Result<LoadedCameras> LoadCamerasUnchanged(const std::filesystem::path& path, CameraFileOptions options = {});

}  // namespace rigcal
