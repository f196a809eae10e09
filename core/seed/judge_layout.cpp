#include "core/seed/judge_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <set>

#include "core/base/median.h"

namespace rigcal {
namespace {

// Pitch over edge by corners as libapriltag finds them: in a blurred picture with tags of 15 pixels it was 5 % too
// large.
constexpr double kRoughSpacingTolerance = 0.15;
// Tags hang together when each one's corners tell the other's centre to this share of their distance. Perspective,
// distortion and tags of 20 pixels stay below 0.1.
constexpr double kLinkTolerance = 0.2;
constexpr double kMaxLinkSteps = 3;
// A length that is as near to the ratio seen is one (ratios in use: 0.2 to 0.5).
constexpr double kRatioTolerance = 0.04;
constexpr std::size_t kNamedIds = 8;  // that a message lists at most

struct Offset {
  int columns = 0, rows = 0;
};

Offset Between(const Board& board, int from, int to) {
  const int a = from - board.first_id, b = to - board.first_id;
  return {b % board.columns - a % board.columns, b / board.columns - a / board.columns};
}

// The centre of tag b in edges of tag a from the centre of tag a, x to its right and y up, by a's corners alone.
std::optional<Eigen::Vector2d> CentreInEdges(const FoundTag& a, const FoundTag& b) {
  const std::array<cv::Point2f, 4> square = {cv::Point2f(-0.5f, -0.5f), {0.5f, -0.5f}, {0.5f, 0.5f}, {-0.5f, 0.5f}};
  std::array<cv::Point2f, 4> picture;
  for (int k = 0; k < kCornersPerTag; ++k)
    picture[k] = {static_cast<float>(a.corners_px[k].x()), static_cast<float>(a.corners_px[k].y())};
  const cv::Matx33d tag_from_picture = cv::getPerspectiveTransform(picture.data(), square.data());
  // Centre of a projected square: where its diagonals meet.
  const Eigen::Vector2d p = b.corners_px[0], r = b.corners_px[2] - p, q = b.corners_px[1], s = b.corners_px[3] - q;
  const double cross = r.x() * s.y() - r.y() * s.x();
  if (cross == 0) return std::nullopt;
  const Eigen::Vector2d centre = p + r * (((q - p).x() * s.y() - (q - p).y() * s.x()) / cross);
  const cv::Vec3d x = tag_from_picture * cv::Vec3d(centre.x(), centre.y(), 1);
  if (x[2] * tag_from_picture(2, 2) <= 0) return std::nullopt;
  return Eigen::Vector2d(x[0] / x[2], x[1] / x[2]);
}

// Steps from a tag to its right and to its upper neighbour, in edges of the tag: (pitch / tag_m, 0) and (0, pitch /
// tag_m) on a board as it should be.
struct MeasuredSteps {
  std::vector<double> right_x, right_y, up_x, up_y;
};

MeasuredSteps MeasureSteps(const Board& board, const std::vector<FoundTag>& tags) {
  MeasuredSteps steps;
  for (const FoundTag& a : tags) {
    for (const FoundTag& b : tags) {
      const Offset offset = Between(board, a.id, b.id);
      if (std::abs(offset.columns) + std::abs(offset.rows) != 1) continue;
      const std::optional<Eigen::Vector2d> centre = CentreInEdges(a, b);
      if (!centre) continue;
      const Eigen::Vector2d step = *centre * (offset.columns + offset.rows);
      (offset.columns != 0 ? steps.right_x : steps.up_x).push_back(step.x());
      (offset.columns != 0 ? steps.right_y : steps.up_y).push_back(step.y());
    }
  }
  return steps;
}

std::string IdList(const std::set<int>& ids) {
  std::string list;
  std::size_t named = 0;
  for (const int id : ids) {
    if (named++ == kNamedIds) return list + fmt::format(" and {} more", ids.size() - kNamedIds);
    list += (list.empty() ? "" : ", ") + std::to_string(id);
  }
  return list;
}

// Whether the ids run to the right and upwards, and which gap is seen.
std::optional<ChartFinding> JudgeSteps(const Board& board, const MeasuredSteps& steps, double tolerance) {
  const double expected = 1 + board.gap_m / board.tag_m;
  const bool has_right = !steps.right_x.empty(), has_up = !steps.up_x.empty();
  const double right_x = has_right ? Median(steps.right_x) : expected, right_y = has_right ? Median(steps.right_y) : 0;
  const double up_x = has_up ? Median(steps.up_x) : 0, up_y = has_up ? Median(steps.up_y) : expected;
  if (std::abs(right_y) > std::abs(right_x) || std::abs(up_x) > std::abs(up_y) || right_x * up_y < 0 || right_x < 0)
    return ChartFinding{
        ChartFindingKind::kLayout,
        fmt::format("ids do not run to the right and upwards as on a board of {} columns from id {}: the next id "
                    "lies {:+.2f} tags to the right and {:+.2f} up, the next row {:+.2f} and {:+.2f}",
                    board.columns, board.first_id, right_x, right_y, up_x, up_y),
        true};
  const auto off = [&](double measured) { return std::abs(measured / expected - 1) > tolerance; };
  if (!off(right_x) && !off(up_y)) return std::nullopt;
  const double share_x = right_x - 1, share_y = up_y - 1;
  std::string message = fmt::format(
      "the gap between tags is {:.3f} (across) and {:.3f} (up) of a tag's edge in the picture, but {:.3f} by the "
      "board file (gap_m {:.6g} by tag_m {:.6g}), and may differ by {:.0f} % of the pitch",
      share_x, share_y, board.gap_m / board.tag_m, board.gap_m, board.tag_m, 100 * tolerance);
  if (std::abs(board.gap_m - (share_x + share_y) / 2) < kRatioTolerance)
    message += fmt::format("; gap_m looks like a spacing ratio: as a length it is {:.5g}", board.gap_m * board.tag_m);
  return ChartFinding{ChartFindingKind::kSpacing, message, true};
}

bool Linked(const Board& board, const FoundTag& a, const FoundTag& b) {
  const Offset offset = Between(board, a.id, b.id);
  const double steps = std::hypot(offset.columns, offset.rows);
  if (steps == 0 || steps > kMaxLinkSteps) return false;
  const double pitch = 1 + board.gap_m / board.tag_m;
  const Eigen::Vector2d expected(offset.columns * pitch, offset.rows * pitch);
  const auto right = [&](const std::optional<Eigen::Vector2d>& seen, double sign) {
    return seen && (*seen - sign * expected).norm() <= kLinkTolerance * expected.norm();
  };
  return right(CentreInEdges(a, b), 1) && right(CentreInEdges(b, a), -1);
}

// Groups of tags that hang together, the largest first; of equals the one that holds the lower index.
std::vector<std::vector<int>> LinkedGroups(const Board& board, const std::vector<FoundTag>& tags) {
  const int count = static_cast<int>(tags.size());
  std::vector<int> group(count);
  std::iota(group.begin(), group.end(), 0);
  const auto root = [&](int i) {
    while (group[i] != i) i = group[i];
    return i;
  };
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j)
      if (root(i) != root(j) && Linked(board, tags[i], tags[j]))
        group[std::max(root(i), root(j))] = std::min(root(i), root(j));
  std::map<int, std::vector<int>> by_root;
  for (int i = 0; i < count; ++i) by_root[root(i)].push_back(i);
  std::vector<std::vector<int>> groups;
  for (auto& [_, members] : by_root) groups.push_back(std::move(members));
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

std::set<int> Doubled(const std::vector<FoundTag>& tags) {
  std::set<int> seen, doubled;
  for (const FoundTag& tag : tags)
    if (!seen.insert(tag.id).second) doubled.insert(tag.id);
  return doubled;
}

}  // namespace

std::optional<ChartFinding> JudgeSpacing(const Board& board, const std::vector<FoundTag>& refined) {
  return JudgeSteps(board, MeasureSteps(board, refined), kSpacingTolerance);
}

ChartFinding StrayTags(const std::set<int>& ids) {
  return {ChartFindingKind::kStrayTags,
          fmt::format("tags {} do not lie where the board has them and are left out", IdList(ids))};
}

JudgedTags JudgeLayout(const Board& board, const std::vector<FoundTag>& found) {
  JudgedTags judged;
  std::vector<FoundTag> own;
  std::set<int> foreign;
  for (const FoundTag& tag : found) {
    if (board.HasTag(tag.id))
      own.push_back(tag);
    else
      foreign.insert(tag.id);
  }
  if (!foreign.empty())
    judged.findings.push_back({ChartFindingKind::kForeignIds,
                               fmt::format("tags {} are not on the board, which has ids {} to {}", IdList(foreign),
                                           board.first_id, board.first_id + board.NumTags() - 1)});
  const std::set<int> doubled = Doubled(own);
  if (doubled.empty()) {
    if (std::optional<ChartFinding> wrong = JudgeSteps(board, MeasureSteps(board, own), kRoughSpacingTolerance)) {
      judged.findings.push_back(std::move(*wrong));
      return judged;
    }
  }
  const std::vector<std::vector<int>> groups = LinkedGroups(board, own);
  if (groups.empty()) return judged;
  if (!doubled.empty()) {
    const bool two_boards = groups.size() > 1 && 2 * groups[1].size() > groups[0].size();
    judged.findings.push_back(
        {ChartFindingKind::kDoubledIds,
         fmt::format("ids {} are there twice: {}", IdList(doubled),
                     two_boards ? "two boards, or a board and its reflection; which one is meant cannot be told"
                                : "what does not lie on the board is left out"),
         two_boards});
    if (two_boards) return judged;
  }
  if (groups[0].size() == 1 && own.size() > 1) {
    judged.findings.push_back({ChartFindingKind::kStrayTags,
                               fmt::format("none of the {} tags found lies where another one tells", own.size()),
                               true});
    return judged;
  }
  for (std::size_t g = 1; g < groups.size(); ++g)
    for (const int i : groups[g])
      if (!doubled.contains(own[i].id)) judged.stray_ids.insert(own[i].id);
  for (const int i : groups[0]) judged.tags.push_back(own[i]);
  return judged;
}

}  // namespace rigcal
