#include "daemon/cli/mask_options.h"

namespace rigcal {

MaskSource MaskRequest::Source() const {
  if (source == "auto") return MaskSource::kAuto;
  return source == "none" ? MaskSource::kNone : MaskSource::kFolder;
}

Result<void> MaskRequest::Check() const {
  if (mask_from_name.empty() || Source() == MaskSource::kFolder) return {};
  return Fail(ErrorCode::kBadInput, "--mask-from-name {} needs a folder of masks, --masks is {}", mask_from_name,
              source);
}

std::filesystem::path MaskRequest::Folder() const {
  return Source() == MaskSource::kFolder ? source : "";
}

void AddMaskOptions(CLI::App& command, MaskRequest& request) {
  command
      .add_option("--masks", request.source,
                  "Folder of masks (same stem as the image, 128 and above is object), or auto: find silhouettes, or "
                  "none; ./auto is a folder of that name")
      ->type_name("DIR|auto|none")
      ->capture_default_str();
  command
      .add_option("--mask-from-name", request.mask_from_name,
                  "Stem of the mask from the image's stem, as in 'image_0*([0-9]+)=contour_$1'")
      ->type_name("REGEX=REPLACEMENT");
}

}  // namespace rigcal
