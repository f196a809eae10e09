#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/drift/rig_evidence.h"

namespace rigcal {

/// How the pictures of object points follow a rigid motion: one 2 x 6 block for each point of each view that counts.
using PictureRows = std::vector<Eigen::Matrix<double, 2, kMotionSize>>;

/// By the motion of a camera's own mount; empty for one without pictures. Points that are not in front of it are left
/// out.
PictureRows RowsOfCamera(const DriftInput& input, int camera);

/// The same without what a similarity of the object would do to that camera's pictures (least squares): the part of its
/// motion that a camera without others can show.
PictureRows RowsOfLoneCamera(const DriftInput& input, int camera);

/// Through all cameras that have a place in the rig, by one motion of what carries them; without what a similarity of
/// the object would do to all their pictures.
PictureRows RowsOfAll(const DriftInput& input);

PictureMotion MotionOf(const PictureRows& rows, const MotionVector& motion, const MotionMatrix& covariance);

}  // namespace rigcal
