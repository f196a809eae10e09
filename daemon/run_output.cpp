#include "daemon/run_output.h"

#include <algorithm>

#include "config/atomic_file.h"
#include "config/calibration_file.h"
#include "config/middlebury.h"
#include "config/patches_file.h"
#include "config/recording_file.h"

namespace rigcal {
namespace {

constexpr const char *kCalibrationFile = "calibration.json", *kMiddleburyFile = "cameras_par.txt";

}  // namespace

Result<void> PrepareResultFolder(const std::filesystem::path& folder, const std::filesystem::path& cameras) {
  std::error_code error;
  if (std::filesystem::exists(folder / kRecordingFile, error)) {
    return Fail(ErrorCode::kBadInput, "{}: is a recording; results need a folder of their own", folder.string());
  }
  for (const char* result : {kCalibrationFile, kMiddleburyFile}) {
    if (std::filesystem::equivalent(folder / result, cameras, error)) {
      return Fail(ErrorCode::kBadInput, "{}: its {} is what the run reads; results need a folder of their own",
                  folder.string(), result);
    }
  }
  return PrepareOutputFolder(folder);
}

Result<void> WriteRunOutput(const RefinedRig& rig, const Provenance& provenance, const std::filesystem::path& folder) {
  if (auto written = WritePatches(folder / "patches.ply", rig.patches, rig.patch_colours_bgr); !written) return written;
  if (auto written = WriteCalibration(folder / kCalibrationFile, rig.calibration, provenance); !written) {
    return written;
  }
  const auto& cameras = rig.calibration.cameras;
  if (std::ranges::none_of(cameras, &Camera::HasDistortion)) {
    auto written = WriteFileAtomically(folder / kMiddleburyFile, MiddleburyText(rig.calibration));
    if (!written) return written;
  } else {
    std::error_code error;
    std::filesystem::remove(folder / kMiddleburyFile, error);  // an earlier run's
  }
  return WriteReportJson(rig.report, folder / "report.json");
}

}  // namespace rigcal
