#include "core/seed/detect_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/median.h"
#include "core/seed/drop_strays.h"
#include "core/seed/explain_absence.h"
#include "core/seed/find_tags.h"
#include "core/seed/gamma.h"
#include "core/seed/predict_tags.h"
#include "core/seed/tag_family.h"

namespace rigcal {
namespace {

// What surrounds corner k of a tag, by its four corners in the picture.
CornerPlace PlaceOf(const Board& board, const TagFamily& family, const FoundTag& tag, int k) {
  const int next = (k + 1) % kCornersPerTag, previous = (k + kCornersPerTag - 1) % kCornersPerTag;
  CornerPlace place;
  place.x_px = tag.corners_px[k];
  place.is_crossing = family.BorderCells() > 1;
  const std::array<Eigen::Vector2d, 2> edge = {tag.corners_px[next] - place.x_px,
                                               tag.corners_px[previous] - place.x_px};
  const double edge_cells = family.EdgeCells();
  const double gap_cells = board.gap_m / board.tag_m * edge_cells;
  for (int e = 0; e < 2; ++e) {
    place.length_px[e] = edge[e].norm();
    place.along[e] = edge[e] / place.length_px[e];
  }
  const double sine = std::abs(place.along[0].x() * place.along[1].y() - place.along[0].y() * place.along[1].x());
  for (int e = 0; e < 2; ++e) {
    const double cell_px = place.length_px[1 - e] * sine / edge_cells;  // across edge e
    place.inside_px[e] = cell_px * family.BorderCells();
    // A tag needs one cell around it and may have more; a neighbour comes after the gap.
    place.outside_px[e] = cell_px * (place.is_crossing ? gap_cells : std::min(gap_cells, 1.0));
  }
  return place;
}

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
      better.corners[k] = RefineCorner(picture, PlaceOf(board, family, tag, k), limits);
  }
  return refined;
}

// Tags of which every corner is refined.
std::vector<FoundTag> WholeTags(const std::vector<RefinedTag>& tags) {
  std::vector<FoundTag> whole;
  for (const RefinedTag& tag : tags) {
    if (!std::all_of(tag.corners.begin(), tag.corners.end(), [](const auto& corner) { return corner.has_value(); }))
      continue;
    FoundTag& copy = whole.emplace_back(FoundTag{tag.id, 0, {}});
    for (int k = 0; k < kCornersPerTag; ++k) copy.corners_px[k] = tag.corners[k]->x_px;
  }
  return whole;
}

void CollectCorners(const Board& board, const std::vector<RefinedTag>& tags, ChartDetection& detection) {
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
  for (std::size_t i = 0; i < detection.corners.size(); ++i)
    if (i == 0 || detection.corners[i].tag_id != detection.corners[i - 1].tag_id) ++detection.num_tags;
  const std::size_t expected = tags.size() * kCornersPerTag;
  if (detection.corners.size() < expected)
    detection.findings.push_back(
        {ChartFindingKind::kLostCorners,
         fmt::format(
             "{} of {} corners cannot be trusted (hidden, blurred, over-exposed or at the rim) and are left out",
             expected - detection.corners.size(), expected)});
}

}  // namespace

Result<ChartDetection> DetectChart(const cv::Mat1f& picture, const Board& board, const ChartOptions& options) {
  if (picture.empty()) return Fail(ErrorCode::kBadInput, "chart: the picture has no pixels");
  const Result<TagFamily> family = TagFamily::Make(board.family, board.border_bits);
  if (!family) return Fail(family.error());
  if (board.columns < 1 || board.rows < 1 || board.first_id < 0 ||
      board.first_id + board.NumTags() > family->NumCodes())
    return Fail(ErrorCode::kBadInput, "chart: {} x {} tags from id {} do not exist in {}, which has ids 0 to {}",
                board.columns, board.rows, board.first_id, board.family, family->NumCodes() - 1);
  const cv::Mat1b encoded = EightBits(options.linear ? SrgbEncodedPicture(picture) : picture);
  const std::vector<FoundTag> found = FindTags(encoded, *family);
  JudgedTags judged = JudgeLayout(board, found);
  ChartDetection detection;
  detection.findings = std::move(judged.findings);
  if (judged.tags.empty()) {
    if (detection.findings.empty() && options.diagnose) detection.findings.push_back(ExplainAbsence(encoded, board));
    return detection;
  }
  std::vector<FoundTag> tags = std::move(judged.tags);
  if (options.predict) {
    const std::vector<FoundTag> predicted = PredictTags(picture, board, *family, tags);
    detection.num_predicted = static_cast<int>(predicted.size());
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
  CollectCorners(board, refined, detection);
  return detection;
}

}  // namespace rigcal
