#include "daemon/picture_source.h"

namespace rigcal {

Result<OpenedPictures> OpenPictures(const PictureSource& source) {
  OpenedPictures pictures{.folder = source.images};
  pictures.naming.camera_from_name = source.camera_from_name;
  if (source.recording.empty()) return pictures;
  Result<RecordedObject> recorded = LoadRecordedObject(source.recording);
  if (!recorded) return Fail(recorded.error());
  pictures.folder = source.recording;
  pictures.naming.camera_by_image = recorded->camera_by_image;
  pictures.files = {recorded->file};
  pictures.recorded = std::move(*recorded);
  return pictures;
}

}  // namespace rigcal
