#include "core/seed/predict_tags.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "core/image/sample.h"

namespace rigcal {
namespace {

constexpr std::size_t kMaxNeighbours = 8;  // of a tag inside the board; more see more distortion
constexpr std::size_t kMinNeighbours = 2;  // a single small tag extrapolates its own corner noise
// Correlation of grey values with the pattern. True tags had 0.6 to 0.95 on yac-aprilgrid, other places below 0.35.
constexpr double kMinCorrelation = 0.5;
// Least edge for which cells can be told apart at all, in pixels for each cell.
constexpr double kMinCellPx = 1.2;

// Distance of two tags on the board, in steps.
double Steps(const Board& board, int a, int b) {
  const int from = a - board.first_id, to = b - board.first_id;
  return std::hypot(from % board.columns - to % board.columns, from / board.columns - to / board.columns);
}

cv::Matx33d SquareToPicture(const std::array<Eigen::Vector2d, kCornersPerTag>& corners_px, double edge) {
  // Rows of the printed pattern count downwards from the upper left corner (3).
  const std::array<cv::Point2f, 4> square = {cv::Point2f(0, static_cast<float>(edge)),
                                             cv::Point2f(static_cast<float>(edge), static_cast<float>(edge)),
                                             cv::Point2f(static_cast<float>(edge), 0), cv::Point2f(0, 0)};
  std::array<cv::Point2f, 4> picture;
  for (int i = 0; i < kCornersPerTag; ++i)
    picture[i] = {static_cast<float>(corners_px[i].x()), static_cast<float>(corners_px[i].y())};
  return cv::getPerspectiveTransform(square.data(), picture.data());
}

struct Agreement {
  int wrong_cells = 0;
  double correlation = 0;
};

// How the cells of the picture agree with those of the pattern. Nothing when the tag is not all in the picture.
std::optional<Agreement> Compare(const cv::Mat1f& picture, const TagFamily& family, int id,
                                 const std::array<Eigen::Vector2d, kCornersPerTag>& corners_px) {
  const cv::Mat1b cells = family.Cells(id);
  const int outside = (family.TotalCells() - family.EdgeCells()) / 2;
  const cv::Matx33d picture_from_cells = SquareToPicture(corners_px, family.EdgeCells());
  const int first = family.ReversedBorder() ? -outside : 0;
  std::vector<std::pair<double, bool>> seen;  // grey value, white in print
  Eigen::Vector2d level = Eigen::Vector2d::Zero(), count = Eigen::Vector2d::Zero();
  for (int row = first; row < family.EdgeCells() - first; ++row) {
    for (int column = first; column < family.EdgeCells() - first; ++column) {
      const cv::Vec3d at = picture_from_cells * cv::Vec3d(column + 0.5, row + 0.5, 1);
      const double x = at[0] / at[2], y = at[1] / at[2];
      if (!CanSample(picture, x, y, 1)) return std::nullopt;
      // Cubic interpolation overshoots a little, which sharpens cells of two pixels.
      const double value = SampleCubic(picture, static_cast<float>(x), static_cast<float>(y)).value;
      const bool white = cells(row + outside, column + outside) != 0;
      seen.emplace_back(value, white);
      level[white] += value, count[white] += 1;
    }
  }
  if (count[0] == 0 || count[1] == 0) return std::nullopt;
  level = level.cwiseQuotient(count);
  const double middle = level.mean(), mean = level.dot(count) / count.sum(), share = count[1] / count.sum();
  Agreement agreement;
  double product = 0, square = 0;
  for (const auto& [value, white] : seen) {
    agreement.wrong_cells += (value > middle) != white;
    product += (value - mean) * ((white ? 1 : 0) - share);
    square += (value - mean) * (value - mean);
  }
  const double pattern = count.sum() * share * (1 - share);
  agreement.correlation = square > 0 ? product / std::sqrt(square * pattern) : 0;
  return agreement;
}

}  // namespace

std::optional<std::array<Eigen::Vector2d, kCornersPerTag>> PredictCorners(const Board& board, int id,
                                                                          const std::vector<FoundTag>& neighbours) {
  std::vector<const FoundTag*> nearest;
  for (const FoundTag& tag : neighbours)
    if (tag.id != id) nearest.push_back(&tag);
  std::sort(nearest.begin(), nearest.end(), [&](const FoundTag* a, const FoundTag* b) {
    return std::tuple(Steps(board, id, a->id), a->id) < std::tuple(Steps(board, id, b->id), b->id);
  });
  if (nearest.size() < kMinNeighbours) return std::nullopt;
  nearest.resize(std::min(nearest.size(), kMaxNeighbours));
  std::vector<cv::Point2d> on_board, in_picture;
  const Eigen::Vector3d origin = TagCornerInBoard(board, id, 0);
  for (const FoundTag* tag : nearest) {
    for (int k = 0; k < kCornersPerTag; ++k) {
      const Eigen::Vector3d x_in_edges = (TagCornerInBoard(board, tag->id, k) - origin) / board.tag_m;
      on_board.emplace_back(x_in_edges.x(), x_in_edges.y());
      in_picture.emplace_back(tag->corners_px[k].x(), tag->corners_px[k].y());
    }
  }
  const cv::Mat homography = cv::findHomography(on_board, in_picture);
  if (homography.empty()) return std::nullopt;
  const cv::Matx33d picture_from_board = homography;
  std::array<Eigen::Vector2d, kCornersPerTag> corners_px;
  for (int k = 0; k < kCornersPerTag; ++k) {
    const Eigen::Vector3d x_in_edges = (TagCornerInBoard(board, id, k) - origin) / board.tag_m;
    const cv::Vec3d x = picture_from_board * cv::Vec3d(x_in_edges.x(), x_in_edges.y(), 1);
    if (!(x[2] > 0)) return std::nullopt;
    corners_px[k] = {x[0] / x[2], x[1] / x[2]};
  }
  return corners_px;
}

std::vector<FoundTag> PredictTags(const cv::Mat1f& picture, const Board& board, const TagFamily& family,
                                  const std::vector<FoundTag>& found) {
  std::vector<FoundTag> known = found, predicted;
  std::vector<int> missing;
  for (int id = board.first_id; id < board.first_id + board.NumTags(); ++id)
    if (std::none_of(found.begin(), found.end(), [&](const FoundTag& tag) { return tag.id == id; }))
      missing.push_back(id);
  for (bool grown = true; grown && !missing.empty();) {
    std::vector<FoundTag> fresh;
    for (const int id : missing) {
      const auto corners_px = PredictCorners(board, id, known);
      if (!corners_px) continue;
      const FoundTag candidate{id, 0, *corners_px};
      if (candidate.ShortestEdgePx() < kMinCellPx * family.EdgeCells()) continue;
      const std::optional<Agreement> agreement = Compare(picture, family, id, *corners_px);
      if (!agreement || agreement->wrong_cells > family.CorrectableCells() || agreement->correlation < kMinCorrelation)
        continue;
      fresh.push_back({id, agreement->wrong_cells, *corners_px});
    }
    for (const FoundTag& tag : fresh) std::erase(missing, tag.id);
    known.insert(known.end(), fresh.begin(), fresh.end());
    predicted.insert(predicted.end(), fresh.begin(), fresh.end());
    grown = !fresh.empty();
  }
  std::sort(predicted.begin(), predicted.end(), [](const FoundTag& a, const FoundTag& b) { return a.id < b.id; });
  return predicted;
}

}  // namespace rigcal
