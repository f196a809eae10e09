#include "config/recording_check.h"

#include <algorithm>
#include <optional>
#include <set>

#include "config/decode_image.h"
#include "config/recording_file.h"
#include "config/recording_pictures.h"
#include "core/image/exposure.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

/// What one picture has against itself.
struct PictureFinding {
  std::optional<std::string> fault, remark;
};

PictureFinding CheckPicture(const fs::path& folder, const Recording& recording, int view) {
  const Result<cv::Mat> picture = LoadRecordedPicture(folder, recording, view);
  if (!picture) return {.fault = picture.error().message, .remark = {}};
  const double share = SaturatedShare(GrayOf(*picture), {});
  if (share <= kMaxSaturatedShare) return {};
  return {.fault = {},
          .remark = fmt::format("{}: {:.0f} % of its pixels are saturated (limit {:.0f} %): over-exposed, unless it is "
                                "the backdrop",
                                (folder / recording.views[view].file).string(), 100 * share, 100 * kMaxSaturatedShare)};
}

/// Stops and cameras that no view belongs to: normal, but worth a look.
std::vector<std::string> Unseen(const Recording& recording) {
  std::set<int> cameras, stops;
  for (const RecordedView& view : recording.views) {
    cameras.insert(view.camera);
    if (view.stop) stops.insert(*view.stop);
  }
  std::vector<std::string> remarks;
  for (int c = 0; c < static_cast<int>(recording.cameras.size()); ++c)
    if (!cameras.contains(c)) remarks.push_back(fmt::format("camera '{}' has no view", recording.cameras[c].id));
  for (int s = 0; s < static_cast<int>(recording.stops.size()); ++s)
    if (!stops.contains(s)) remarks.push_back(fmt::format("stop '{}' has no view", recording.stops[s].id));
  return remarks;
}

}  // namespace

std::vector<std::string> ForeignFiles(const fs::path& folder, const Recording& recording) {
  std::set<std::string> known = {kRecordingFile};
  for (const RecordedView& view : recording.views) known.insert(view.file);
  std::vector<std::string> foreign;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().lexically_relative(folder).generic_string();
    if (it->symlink_status(error).type() != fs::file_type::directory && !known.contains(name)) foreign.push_back(name);
  }
  std::sort(foreign.begin(), foreign.end());
  return foreign;
}

Result<RecordingFindings> CheckRecording(const fs::path& folder, const Execution& execution) {
  Result<Recording> recording = LoadRecording(folder);
  if (!recording) return Fail(recording.error());
  const std::string file = (folder / kRecordingFile).string();
  RecordingFindings findings;
  if (!recording->closed)
    findings.faults.push_back(fmt::format("{}: the recording is not closed: it was interrupted after {} views", file,
                                          recording->views.size()));
  if (recording->views.empty()) findings.faults.push_back(file + ": the recording is empty, it has no view");
  std::vector<PictureFinding> pictures(recording->views.size());
  const bool finished = ParallelFor(execution, static_cast<int>(pictures.size()),
                                    [&](int view) { pictures[view] = CheckPicture(folder, *recording, view); });
  if (!finished) return Cancelled("checking the recording");
  for (const PictureFinding& picture : pictures) {
    if (picture.fault) findings.faults.push_back(*picture.fault);
    if (picture.remark) findings.remarks.push_back(*picture.remark);
  }
  for (const std::string& remark : Unseen(*recording)) findings.remarks.push_back(file + ": " + remark);
  for (const std::string& name : ForeignFiles(folder, *recording))
    findings.remarks.push_back((folder / name).string() + ": is not part of the recording");
  findings.recording = std::move(*recording);
  return findings;
}

}  // namespace rigcal
