#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/calibration_store.h"
#include "core/base/result.h"

namespace rigcal {

/// What a report.json, of a refinement or of a seed, says about its calibration.
struct ReportedVerdict {
  Verdict verdict = Verdict::kInconclusive;
  std::vector<std::string> reasons;
};

/// A refinement's report names its verdict. A seed's is accepted, unless its pictures and the rig contradict each
/// other: then it is inconclusive and the contradictions are the reasons. `file` starts messages. Errors: kBadInput,
/// kUnsupported (a newer version).
Result<ReportedVerdict> ParseReportedVerdict(std::string_view text, const std::string& file);

/// The result folder of `refine` or `seed` (calibration.json, report.json) as a revision for the rig, made at `time`.
/// `recording`, when not empty, is the folder of the recording it came from, and tells the recording's id. The seed's
/// revision is the one of `store` with the calibration that the run says it has read. Errors: those of ReadFile, the
/// store and the parsers; kBadInput: the recording is not the one that the run has read.
Result<CalibrationRevision> RevisionFromResult(const std::filesystem::path& folder,
                                               const std::filesystem::path& recording, const std::string& rig,
                                               const std::string& time, CalibrationStore& store);

}  // namespace rigcal
