#include "daemon/mask_request.h"

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

}  // namespace rigcal
