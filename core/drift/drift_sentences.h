#pragma once

#include <string>
#include <vector>

#include "core/drift/judge_drift.h"

namespace rigcal {

/// "ok", "drifting", "failed" or "inconclusive": as drift.json has it.
const char* NameOf(DriftState state);

/// "motion (cam1): 0.31 px against a limit of 0.15 px".
std::string ReasonText(const DriftReason& reason);

/// What people are told; the first sentence begins with the state and says it all.
std::vector<std::string> SentencesOf(const DriftInput& input, const DriftFinding& finding);

}  // namespace rigcal
