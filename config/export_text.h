#pragma once

#include <map>
#include <string>

#include "core/scene/rig_calibration.h"

namespace rigcal {

/// The files of one exported calibration: path below the target folder and content.
using ExportedFiles = std::map<std::string, std::string>;

/// cameras.txt, images.txt and an empty points3D.txt. No camera has skew and all sizes are known.
ExportedFiles ColmapFiles(const RigCalibration& calibration);

/// txt/00000000.txt .. with CONTOUR matrices, scaled so that the third row's direction has length 1, and views.txt,
/// which names the image of each number. No camera has distortion.
ExportedFiles PmvsFiles(const RigCalibration& calibration);

/// An OpenCV FileStorage document (keys: docs/formats.md).
std::string OpenCvText(const RigCalibration& calibration);

}  // namespace rigcal
