#include "config/middlebury.h"

#include <cmath>

#include "config/formats/writers.h"
#include "config/text_fields.h"
#include "core/base/ensure.h"

namespace rigcal {
namespace {

constexpr std::size_t kNumbersPerView = 21;
constexpr double kMaxLowerEntry = 1e-9;  // k21, k31, k32 and k33 - 1 must be 0 up to rounding

Result<CameraRecord> ParseView(const TextLine& line, const std::string& file) {
  const std::vector<std::string_view> fields = SplitFields(line.text);
  CameraRecord record;
  record.name = std::string(fields[0]);
  record.where = fmt::format("{} line {} ({})", file, line.number, record.name);
  if (fields.size() != 1 + kNumbersPerView)
    return Fail(ErrorCode::kBadInput, "{}: {} numbers after the image name instead of {}", record.where,
                fields.size() - 1, kNumbersPerView);
  const auto numbers = ParseNumbers(std::span(fields).subspan(1), record.where);
  if (!numbers) return Fail(numbers.error());
  const double* n = numbers->data();
  for (const auto& [name, value] : {std::pair("k21", n[3]), {"k31", n[6]}, {"k32", n[7]}, {"k33 - 1", n[8] - 1}}) {
    if (std::abs(value) > kMaxLowerEntry)
      return Fail(ErrorCode::kBadInput, "{}: {} of the calibration matrix is {} instead of 0", record.where, name,
                  value);
  }
  record.camera.fx_px = n[0], record.camera.skew_px = n[1], record.camera.cx_px = n[2];
  record.camera.fy_px = n[4], record.camera.cy_px = n[5];
  const Eigen::Matrix3d matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(n + 9);
  const auto rotation = RotationFromMatrix(matrix, record.where);
  if (!rotation) return Fail(rotation.error());
  record.cam_from_world = {*rotation, Eigen::Vector3d(n[18], n[19], n[20])};
  return record;
}

}  // namespace

Result<std::vector<CameraRecord>> ParseMiddlebury(std::string_view text, const std::string& file) {
  std::vector<TextLine> lines;
  for (const TextLine& line : SplitLines(text))
    if (!Trimmed(line.text).empty()) lines.push_back(line);
  if (lines.empty()) return Fail(ErrorCode::kBadInput, "{}: the file is empty", file);
  const auto count = ParseCount(Trimmed(lines[0].text), fmt::format("{} line {}", file, lines[0].number));
  if (!count) return Fail(count.error());
  if (*count != static_cast<int>(lines.size()) - 1)
    return Fail(ErrorCode::kBadInput, "{} line {}: announces {} images, {} lines follow", file, lines[0].number, *count,
                lines.size() - 1);
  std::vector<CameraRecord> records;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    Result<CameraRecord> record = ParseView(lines[i], file);
    if (!record) return Fail(record.error());
    records.push_back(*std::move(record));
  }
  return records;
}

std::string MiddleburyText(const RigCalibration& calibration) {
  for (const Camera& camera : calibration.cameras)
    Ensure(!camera.HasDistortion(), "the Middlebury form knows no distortion");
  return MiddleburyFiles(calibration)->begin()->second;
}

}  // namespace rigcal
