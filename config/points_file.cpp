#include "config/points_file.h"

#include "config/text_fields.h"

namespace rigcal {
namespace {

Result<ComparePoint> ParsePoint(std::string_view line, const std::string& where, int num_views) {
  constexpr std::size_t kCoordinates = 3;
  const std::vector<std::string_view> fields = SplitFields(line);
  if (fields.size() < kCoordinates)
    return Fail(ErrorCode::kBadInput, "{}: {} numbers instead of 'x y z' or 'x y z k v1 .. vk'", where, fields.size());
  const auto position = ParseNumbers(std::span(fields).first(kCoordinates), where);
  if (!position) return Fail(position.error());
  ComparePoint point{Eigen::Map<const Eigen::Vector3d>(position->data()), {}};
  if (fields.size() == kCoordinates) return point;
  const Result<int> count = ParseCount(fields[kCoordinates], where);
  if (!count) return Fail(count.error());
  if (fields.size() - kCoordinates - 1 != static_cast<std::size_t>(*count))
    return Fail(ErrorCode::kBadInput, "{}: announces {} views, {} follow", where, *count,
                fields.size() - kCoordinates - 1);
  for (std::size_t i = kCoordinates + 1; i < fields.size(); ++i) {
    const Result<int> view = ParseCount(fields[i], where);
    if (!view) return Fail(view.error());
    if (*view >= num_views)
      return Fail(ErrorCode::kBadInput, "{}: view {} does not exist, the reference has {} views", where, *view,
                  num_views);
    point.views.push_back(*view);
  }
  return point;
}

}  // namespace

Result<std::vector<ComparePoint>> ParsePoints(std::string_view text, const std::string& file, int num_views) {
  std::vector<ComparePoint> points;
  for (const TextLine& line : SplitLines(text)) {
    const std::string_view content = Trimmed(line.text);
    if (content.empty() || content.starts_with('#')) continue;
    Result<ComparePoint> point = ParsePoint(content, fmt::format("{} line {}", file, line.number), num_views);
    if (!point) return Fail(point.error());
    points.push_back(*std::move(point));
  }
  return points;
}

}  // namespace rigcal
