#include "daemon/run_output.h"

#include <algorithm>

#include "config/atomic_file.h"
#include "config/calibration_file.h"
#include "config/middlebury.h"
#include "config/patches_file.h"

namespace rigcal {

Result<void> WriteRunOutput(const RefinedRig& rig, const Provenance& provenance, const std::filesystem::path& folder) {
  if (auto written = WritePatches(folder / "patches.ply", rig.patches, rig.patch_colours_bgr); !written) return written;
  if (auto written = WriteCalibration(folder / "calibration.json", rig.calibration, provenance); !written) {
    return written;
  }
  const auto& cameras = rig.calibration.cameras;
  if (std::ranges::none_of(cameras, &Camera::HasDistortion)) {
    auto written = WriteFileAtomically(folder / "cameras_par.txt", MiddleburyText(rig.calibration));
    if (!written) return written;
  }
  return WriteReportJson(rig.report, folder / "report.json");
}

}  // namespace rigcal
