#include "daemon/recorded_pictures_source.h"

#include <utility>

#include "config/recording_file.h"
#include "config/recording_pictures.h"

namespace rigcal {

Result<RecordedPictures> OpenRecordedPictures(const std::string& folder) {
  Result<Recording> recording = LoadRecording(folder);
  if (!recording) return Fail(recording.error());
  RecordedPictures pictures{.recording = *recording, .load = {}};
  pictures.load = [folder, recording = std::move(*recording)](int view) -> Result<CapturedPicture> {
    Result<RecordedFile> file = LoadRecordedFile(folder, recording, view);
    if (!file) return Fail(file.error());
    return CapturedPicture{.pixels = file->pixels,
                           .file = PictureFile{recording.views[view].file, std::move(file->bytes)}};
  };
  return pictures;
}

}  // namespace rigcal
