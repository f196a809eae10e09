#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "config/load_cameras.h"
#include "core/geometry/camera.h"
#include "core/geometry/rigid3.h"

namespace rigcal {

/// One view as a camera file states it, before views are gathered into physical cameras.
struct CameraRecord {
  std::string name;   ///< of the image
  std::string where;  ///< "cams_par.txt line 3 (image.png)": starts the message of an Error
  Camera camera;      ///< physical_id: what the file says, or empty; width and height 0 when the file does not say
  Rigid3d cam_from_world;
};

/// The rotation nearest to a matrix that is one to within kMaxRotationError. Errors: kBadInput.
Result<Eigen::Quaterniond> RotationFromMatrix(const Eigen::Matrix3d& matrix, const std::string& where);

/// A quaternion of about unit length, normalised. Errors: kBadInput.
Result<Eigen::Quaterniond> RotationFromQuaternion(double w, double x, double y, double z, const std::string& where);

/// Whether the intrinsics can be those of a camera. Errors: kBadInput.
Result<void> CheckIntrinsics(const Camera& camera, const std::string& where, bool allow_skew);

/// Largest departure of R^T R from the identity, or of |q| from 1, at which numbers still count as a rotation. Files
/// that print four digits stay below.
inline constexpr double kMaxRotationError = 1e-3;

/// Checks the records, gathers them into physical cameras as the options say and fills calibration, sizes_known, notes
/// and the spreads. `file` names the source in messages. Errors: kBadInput.
Result<LoadedCameras> AssembleCameras(const std::vector<CameraRecord>& records, const std::string& file,
                                      const CameraFileOptions& options);

}  // namespace rigcal
