#include "daemon/cli/picture_source.h"

namespace rigcal {

void AddPictureOptions(CLI::App& command, PictureSource& source) {
  CLI::Option_group* group = command.add_option_group("Pictures", "Where the pictures come from");
  group->add_option("--images", source.images, "Folder of photographs");
  CLI::Option* recording = group->add_option(
      "--recording", source.recording, "Recording (docs/recording.md): its pictures of the object, and their cameras");
  group->require_option(1);
  command
      .add_option("--camera-from-name", source.camera_from_name,
                  "Regular expression on the image's name; its first group is the physical camera")
      ->excludes(recording);
}

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
