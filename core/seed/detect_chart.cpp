#include "core/seed/detect_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "core/base/median.h"
#include "core/seed/check_board.h"
#include "core/seed/corner_place.h"
#include "core/seed/drop_strays.h"
#include "core/seed/explain_absence.h"
#include "core/seed/find_tags.h"
#include "core/seed/gamma.h"
#include "core/seed/predict_tags.h"
#include "core/seed/tag_family.h"

namespace rigcal {
namespace {

// Share of its corners below which a board is not believed: the worst picture of yac-aprilgrid keeps 0.6.
constexpr double kMinTrusted = 0.25;

// A tag with the corners that could be refined.
struct RefinedTag {
  int id = 0;
  std::array<std::optional<RefinedCorner>, kCornersPerTag> corners;
};

std::vector<RefinedTag> RefineTags(const RecordedPicture& picture, const Board& board, const TagFamily& family,
                                   const std::vector<FoundTag>& tags, const CornerLimits& limits) {
  std::vector<RefinedTag> refined;
  for (const FoundTag& tag : tags) {
    RefinedTag& better = refined.emplace_back(RefinedTag{tag.id, {}});
    for (int k = 0; k < kCornersPerTag; ++k)
      better.corners[k] = RefineCorner(picture, PlaceOfCorner(family, tag, k, board.gap_m / board.tag_m), limits);
  }
  return refined;
}

// Tags of which every corner is refined.
std::vector<FoundTag> WholeTags(const std::vector<RefinedTag>& tags) {
  std::vector<FoundTag> whole;
  for (const RefinedTag& tag : tags) {
    if (!std::all_of(tag.corners.begin(), tag.corners.end(), [](const auto& corner) { return corner.has_value(); }))
      continue;
    FoundTag& copy = whole.emplace_back(FoundTag{.id = tag.id});
    for (int k = 0; k < kCornersPerTag; ++k) copy.corners_px[k] = tag.corners[k]->x_px;
  }
  return whole;
}

void CollectCorners(const Board& board, const std::vector<RefinedTag>& tags, const std::set<int>& predicted_ids,
                    ChartDetection& detection) {
  std::vector<double> blurs;
  for (const RefinedTag& tag : tags) {
    for (int k = 0; k < kCornersPerTag; ++k) {
      if (!tag.corners[k]) continue;
      detection.corners.push_back({tag.id, k, tag.corners[k]->x_px, tag.corners[k]->covariance_px2});
      blurs.push_back(tag.corners[k]->blur_px);
    }
  }
  detection.blur_px = Median(blurs);
  DropStrays(board, detection.corners);
  for (std::size_t i = 0; i < detection.corners.size(); ++i) {
    const int id = detection.corners[i].tag_id;
    if (i > 0 && id == detection.corners[i - 1].tag_id) continue;
    ++detection.num_tags;
    if (predicted_ids.contains(id)) ++detection.num_predicted;
  }
  const std::size_t expected = tags.size() * kCornersPerTag, lost = expected - detection.corners.size();
  if (lost == 0) return;
  const bool unusable = static_cast<double>(detection.corners.size()) < kMinTrusted * static_cast<double>(expected);
  detection.findings.push_back(
      {ChartFindingKind::kLostCorners,
       fmt::format(
           "{} of {} corners cannot be trusted (hidden, blurred, over-exposed or at the rim) and are left out{}", lost,
           expected,
           unusable ? fmt::format("; with fewer than {:.0f} % the picture is not used", 100 * kMinTrusted) : ""),
       unusable});
  if (!unusable) return;
  detection.corners.clear();
  detection.num_tags = detection.num_predicted = 0;
}

}  // namespace

Result<ChartDetection> DetectChart(const cv::Mat1f& picture, const Board& board, const ChartOptions& options) {
  if (picture.empty()) return Fail(ErrorCode::kBadInput, "chart: the picture has no pixels");
  if (const Result<void> checked = CheckBoard(board); !checked) return Fail(checked.error());
  const Result<TagFamily> family = TagFamily::Make(board.family, board.border_bits);
  const cv::Mat1b encoded = EightBits(options.linear ? SrgbEncodedPicture(picture) : picture);
  const std::vector<FoundTag> found = FindTags(encoded, *family);
  JudgedTags judged = JudgeLayout(board, found);
  ChartDetection detection;
  detection.findings = std::move(judged.findings);
  if (judged.tags.empty()) {
    const bool explained = std::ranges::any_of(detection.findings, &ChartFinding::unusable);
    if (!explained && options.diagnose) detection.findings.push_back(ExplainAbsence(encoded, board));
    return detection;
  }
  std::vector<FoundTag> tags = std::move(judged.tags);
  std::set<int> predicted_ids;
  if (options.predict) {
    const std::vector<FoundTag> predicted = PredictTags(picture, board, *family, tags);
    for (const FoundTag& tag : predicted) predicted_ids.insert(tag.id);
    tags.insert(tags.end(), predicted.begin(), predicted.end());
    std::sort(tags.begin(), tags.end(), [](const FoundTag& a, const FoundTag& b) { return a.id < b.id; });
  }
  for (const FoundTag& tag : tags) judged.stray_ids.erase(tag.id);
  if (!judged.stray_ids.empty()) detection.findings.push_back(StrayTags(judged.stray_ids));
  const std::vector<RefinedTag> refined = RefineTags({picture, options.linear}, board, *family, tags, options.limits);
  if (std::optional<ChartFinding> wrong = JudgeSpacing(board, WholeTags(refined))) {
    detection.findings.push_back(*std::move(wrong));
    return detection;
  }
  CollectCorners(board, refined, predicted_ids, detection);
  // Tags that look like the board's, but have no corner of the kind: most likely another board.
  if (detection.corners.empty() && options.diagnose) detection.findings.push_back(ExplainAbsence(encoded, board));
  return detection;
}

}  // namespace rigcal
