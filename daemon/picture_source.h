#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/load_cameras.h"
#include "config/recording_pictures.h"

namespace rigcal {

/// --images DIR [--camera-from-name REGEX] or --recording DIR, as given.
struct PictureSource {
  std::filesystem::path images, recording;
  std::string camera_from_name;
};

/// Where the pictures lie and what is known about them before they are read.
struct OpenedPictures {
  std::filesystem::path folder;
  CameraFileOptions naming;  ///< which physical camera took which picture; the other options have their defaults
  RecordedObject recorded;   ///< empty for a plain folder
  std::vector<InputFile> files;
};

/// Errors: those of LoadRecordedObject.
Result<OpenedPictures> OpenPictures(const PictureSource& source);

}  // namespace rigcal
