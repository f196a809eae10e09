#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/rigid3.h"
#include "core/scene/rig_estimate.h"

namespace rigcal {

/// One picture: a camera at a stop.
struct View {
  std::string name;  ///< the image's file name, unique in a calibration
  int camera = 0;    ///< index into RigCalibration::cameras
  Rigid3d cam_from_world;
};

enum class LengthUnit { kUnknown, kMetre };

/// Which intrinsics a run estimates: one set for each physical camera, none, or one for each view.
enum class IntrinsicsMode { kPerCamera, kFixed, kPerView };

/// Joint covariance of everything that was estimated. Row and column order: for each camera kNumIntrinsics intrinsics
/// (IntrinsicIndex), then for each view the 6 of Disturbed() (rotation in radians, translation in the calibration's
/// unit). Rows of what was held fixed are zero. The gauge is that of the seed (its prior), not of any one view.
struct CalibrationCovariance {
  Eigen::MatrixXd joint;
  /// Standard deviations of a camera's intrinsics.
  [[nodiscard]] IntrinsicVector IntrinsicsSigma(int camera) const {
    return joint.diagonal().segment<kNumIntrinsics>(IntrinsicsRow(camera)).cwiseMax(0).cwiseSqrt();
  }
  [[nodiscard]] static int IntrinsicsRow(int camera) { return camera * kNumIntrinsics; }
  [[nodiscard]] static int PoseRow(int num_cameras, int view) { return num_cameras * kNumIntrinsics + 6 * view; }
};

/// Cameras and their poses at every stop: the input and the result of a calibration.
struct RigCalibration {
  std::vector<Camera> cameras;
  std::vector<View> views;
  LengthUnit unit = LengthUnit::kUnknown;
  std::optional<CalibrationCovariance> covariance;
  std::optional<RigEstimate> rig;  ///< when the poses are those of a rig: it gives other recordings' views theirs

  [[nodiscard]] const Camera& CameraOf(int view) const { return cameras[views[view].camera]; }
  [[nodiscard]] int NumViews() const { return static_cast<int>(views.size()); }
  [[nodiscard]] int NumCameras() const { return static_cast<int>(cameras.size()); }
};

}  // namespace rigcal
