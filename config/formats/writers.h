#pragma once

#include <string>

#include "config/formats/exported_files.h"
#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// One function for each format, each in a file of its own. The caller has seen to it that the calibration holds
/// nothing that the format cannot say (config/formats/limits.h); what else can go wrong is in the Result. Conventions
/// and where they come from: docs/formats.md.

/// *_par.txt: K, R and t of every view.
Result<ExportedFiles> MiddleburyFiles(const RigCalibration& calibration);

/// cameras.txt, images.txt, an empty points3D.txt; with a rig also rigs.txt and frames.txt (COLMAP 3.12 and later).
Result<ExportedFiles> ColmapTextFiles(const RigCalibration& calibration);
/// The same as .bin, little endian.
Result<ExportedFiles> ColmapBinaryFiles(const RigCalibration& calibration);

/// txt/00000000.txt .. with CONTOUR matrices, the third row's direction of length 1 (PMVS keeps single precision), and
/// views.txt, which names the image of each number.
Result<ExportedFiles> PmvsFiles(const RigCalibration& calibration);

/// An OpenCV FileStorage document.
Result<ExportedFiles> OpenCvFiles(const RigCalibration& calibration);

/// camchain.yaml: the cameras as they are fixed to each other. Errors: kUnsupported when the calibration does not say
/// how (several cameras, no rig, and more than one view of any).
Result<ExportedFiles> KalibrFiles(const RigCalibration& calibration);

/// <camera>.yaml for each camera: intrinsics alone.
Result<ExportedFiles> RosFiles(const RigCalibration& calibration);

/// transforms.json.
Result<ExportedFiles> NerfstudioFiles(const RigCalibration& calibration);

/// A document with one chunk.
Result<ExportedFiles> MetashapeFiles(const RigCalibration& calibration);

/// <image's stem>.xmp for each view. Errors: kUnsupported (two images with one stem).
Result<ExportedFiles> RealityCaptureFiles(const RigCalibration& calibration);

/// sfm_data.json.
Result<ExportedFiles> OpenMvgFiles(const RigCalibration& calibration);

/// <image's stem>.cameramodel for each view, all in one reference frame. Errors: kUnsupported (two images with one
/// stem).
Result<ExportedFiles> MrcalFiles(const RigCalibration& calibration);

/// bundle.out and list.txt.
Result<ExportedFiles> BundlerFiles(const RigCalibration& calibration);

/// Where the pictures have to be resampled to fit an export: for each camera the matrix and distortion of the
/// photographs and the matrix of the undistorted pictures, as cv::undistort takes them (FileStorage YAML).
/// `photographs` and `undistorted` have the same cameras in the same order.
std::string UndistortionText(const RigCalibration& photographs, const RigCalibration& undistorted);

}  // namespace rigcal
