#include "config/export.h"

#include <algorithm>

#include "config/atomic_file.h"
#include "config/export_text.h"
#include "config/middlebury.h"
#include "config/text_fields.h"

namespace rigcal {
namespace {

Result<void> CheckPinhole(const RigCalibration& calibration, std::string_view format) {
  for (const Camera& camera : calibration.cameras)
    if (camera.HasDistortion())
      return Fail(ErrorCode::kUnsupported,
                  "camera '{}' has distortion, which {} cannot hold; --undistorted writes the cameras of undistorted "
                  "images",
                  camera.id, format);
  return {};
}

/// Names with blanks cannot be told from the numbers behind them.
Result<void> CheckNamesAreWords(const RigCalibration& calibration, std::string_view format) {
  for (const View& view : calibration.views)
    if (SplitFields(view.name).size() != 1)
      return Fail(ErrorCode::kUnsupported, "the image name '{}' has blanks, which {} cannot hold", view.name, format);
  return {};
}

Result<void> CheckNoSkew(const RigCalibration& calibration, std::string_view format) {
  for (const Camera& camera : calibration.cameras)
    if (camera.skew_px != 0)
      return Fail(ErrorCode::kUnsupported, "camera '{}' has a skew of {} px, which {} does not know", camera.id,
                  camera.skew_px, format);
  return {};
}

Result<void> CheckColmap(const RigCalibration& calibration) {
  for (const Camera& camera : calibration.cameras) {
    if (camera.width_px <= 0 || camera.height_px <= 0)
      return Fail(ErrorCode::kBadInput, "the image size of camera '{}' is not known, COLMAP needs it", camera.id);
  }
  return CheckNoSkew(calibration, "COLMAP");
}

Result<void> Check(const RigCalibration& calibration, ExportFormat format) {
  switch (format) {
    case ExportFormat::kMiddlebury:
      if (Result<void> names = CheckNamesAreWords(calibration, "Middlebury"); !names) return names;
      return CheckPinhole(calibration, "Middlebury");
    case ExportFormat::kPmvs:
      return CheckPinhole(calibration, "PMVS");
    case ExportFormat::kColmap:
      return CheckColmap(calibration);
    case ExportFormat::kOpenCv:
      break;
  }
  return CheckNoSkew(calibration, "OpenCV");
}

Result<void> WriteFiles(const ExportedFiles& files, const std::filesystem::path& folder) {
  for (const auto& [name, content] : files) {
    const std::filesystem::path path = folder / name;
    if (Result<void> prepared = PrepareOutputFolder(path.parent_path()); !prepared) return prepared;
    if (Result<void> written = WriteFileAtomically(path, content); !written) return written;
  }
  return {};
}

Result<void> Write(const RigCalibration& calibration, ExportFormat format, const std::filesystem::path& out) {
  switch (format) {
    case ExportFormat::kColmap:
      return WriteFiles(ColmapFiles(calibration), out);
    case ExportFormat::kPmvs:
      return WriteFiles(PmvsFiles(calibration), out);
    case ExportFormat::kOpenCv:
      return WriteFileAtomically(out, OpenCvText(calibration));
    case ExportFormat::kMiddlebury:
      break;
  }
  return WriteFileAtomically(out, MiddleburyText(calibration));
}

}  // namespace

std::optional<ExportFormat> ExportFormatFromName(std::string_view name) {
  if (name == "middlebury") return ExportFormat::kMiddlebury;
  if (name == "colmap") return ExportFormat::kColmap;
  if (name == "pmvs") return ExportFormat::kPmvs;
  if (name == "opencv") return ExportFormat::kOpenCv;
  return std::nullopt;
}

Result<std::vector<std::string>> Export(const RigCalibration& calibration, const ExportOptions& options,
                                        const std::filesystem::path& out) {
  RigCalibration exported = calibration;
  std::vector<std::string> notes;
  if (options.undistorted) {
    const bool any = std::any_of(exported.cameras.begin(), exported.cameras.end(),
                                 [](const Camera& camera) { return camera.HasDistortion(); });
    for (Camera& camera : exported.cameras) camera = Undistorted(camera);
    if (any) notes.emplace_back("these cameras fit undistorted images only, not the photographs");
  }
  if (const Result<void> checked = Check(exported, options.format); !checked) return Fail(checked.error());
  if (const Result<void> written = Write(exported, options.format, out); !written) return Fail(written.error());
  return notes;
}

}  // namespace rigcal
