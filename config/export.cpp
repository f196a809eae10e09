#include "config/export.h"

#include <algorithm>

#include "config/atomic_file.h"
#include "config/export_folder.h"
#include "config/formats/marks.h"
#include "config/formats/writers.h"
#include "config/read_file.h"
#include "core/base/ensure.h"

namespace rigcal {
namespace {

constexpr const char* kUndistortionFile = "undistort.yml";

bool SameMatrices(const RigCalibration& a, const RigCalibration& b) {
  return std::equal(a.cameras.begin(), a.cameras.end(), b.cameras.begin(), [](const Camera& left, const Camera& right) {
    return left.CalibrationMatrix() == right.CalibrationMatrix();
  });
}

Result<void> WriteSingleFile(const FormatEntry& entry, const std::string& text, const std::filesystem::path& out) {
  std::error_code error;
  if (std::filesystem::exists(out, error)) {
    const Result<std::string> old = ReadFile(out);
    if (!old) return Fail(old.error());
    if (!old->empty() && !IsExportOf(entry.format, *old))
      return Fail(ErrorCode::kBadInput, "{}: is not an export in the format {} and is kept", out.string(), entry.name);
  }
  return WriteFileAtomically(out, text);
}

}  // namespace

std::optional<ExportFormat> ExportFormatFromName(std::string_view name) {
  const FormatEntry* entry = EntryNamed(name);
  return entry == nullptr ? std::nullopt : std::optional(entry->format);
}

Result<std::vector<std::string>> Export(const RigCalibration& calibration, const ExportOptions& options,
                                        const std::filesystem::path& out) {
  const FormatEntry& entry = EntryOf(options.format);
  const RigCalibration exported = options.undistorted ? UndistortedFor(calibration, entry.gaps) : calibration;
  if (const Result<void> checked = CheckFits(exported, entry.gaps, entry.title); !checked) return Fail(checked.error());
  Result<ExportedFiles> files = entry.files(exported);
  if (!files) return Fail(files.error());
  std::vector<std::string> notes;
  if (!entry.caveat.empty()) notes.emplace_back(entry.caveat);
  const bool other_matrices = !SameMatrices(calibration, exported);
  if (other_matrices) {
    Ensure(entry.is_folder, "a format that needs another matrix has room for undistort.yml");
    (*files)[kUndistortionFile] = UndistortionText(calibration, exported);
    notes.push_back(fmt::format("these cameras fit images undistorted as {} says only, not the photographs",
                                (out / kUndistortionFile).string()));
  } else if (std::any_of(calibration.cameras.begin(), calibration.cameras.end(),
                         [&](const Camera& camera) { return options.undistorted && camera.HasDistortion(); })) {
    notes.emplace_back("these cameras fit undistorted images only, not the photographs");
  }
  const Result<void> written = entry.is_folder ? ReplaceExportFolder(entry.name, *std::move(files), out)
                                               : WriteSingleFile(entry, files->begin()->second, out);
  if (!written) return Fail(written.error());
  return notes;
}

}  // namespace rigcal
