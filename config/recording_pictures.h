#pragma once

#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "config/read_file.h"
#include "core/base/result.h"
#include "core/scene/recording.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// A picture's file and what is in it.
struct RecordedFile {
  std::string bytes;
  cv::Mat pixels;  ///< as DecodeImage gives it
};

/// The picture of a view: there, unchanged since it was recorded, of its camera's size. Errors: kNotFound, kIo,
/// kBadInput, kUnsupported.
Result<RecordedFile> LoadRecordedFile(const std::filesystem::path& folder, const Recording& recording, int view);

/// Its pixels alone.
Result<cv::Mat> LoadRecordedPicture(const std::filesystem::path& folder, const Recording& recording, int view);

/// The object's pictures (subject object or both) of a recording, by the names that views of cameras have: their files.
struct RecordedObject {
  Recording recording;
  std::map<std::string, std::string> camera_by_image;
  std::map<std::string, std::string> sha256_by_image;
  InputFile file;  ///< recording.json; its name is empty for pictures that are none of a recording
};

/// Errors: those of LoadRecording; kBadInput when it is not closed or shows no object.
Result<RecordedObject> LoadRecordedObject(const std::filesystem::path& folder);

/// Whether every picture has a camera; that every camera has its picture is seen when camera_by_image is used.
/// `cameras` names the camera file in messages. Errors: kBadInput.
Result<void> CheckAllHaveCameras(const RecordedObject& object, const RigCalibration& calibration,
                                 const std::string& cameras);

}  // namespace rigcal
