#include "core/drift/drift_sentences.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/joined.h"
#include "core/geometry/shift_text.h"

namespace rigcal {
namespace {

std::string MotionText(const PictureMotion& motion) {
  return fmt::format("{:.2f} px at the object ({}; sigma {:.2f})", motion.moved_px, ShiftText(motion.shift_px),
                     motion.sigma_px);
}

/// Of those that moved, when any did.
const CameraDrift& Largest(const DriftFinding& finding) {
  return *std::ranges::max_element(finding.cameras, {},
                                   [](const CameraDrift& d) { return std::pair(d.moved, d.motion.moved_px); });
}

/// Of the cameras that moved, when it can be told.
std::string MovedText(const DriftFinding& finding) {
  std::vector<std::string> parts;
  for (const CameraDrift& drift : finding.cameras) {
    if (drift.moved) parts.push_back(fmt::format("camera {} moved by {}", drift.camera, MotionText(drift.motion)));
  }
  return Joined(parts, ", ");
}

/// When it cannot be told.
std::string SuspectsText(const DriftInput& input, const DriftFinding& finding) {
  const std::string moved = MotionText(Largest(finding).motion);
  constexpr std::size_t kFewCameras = 2;  // against whom the positioner is as suspect
  std::vector<std::string> suspects;
  for (const std::string& camera : finding.suspects) suspects.push_back("camera " + camera);
  if (finding.cameras.size() <= kFewCameras) suspects.push_back(input.positioner_name);
  return fmt::format("{} moved against each other by {}; which one cannot be told", Joined(suspects, ", "), moved);
}

std::string TogetherText(const DriftInput& input, const DriftFinding& finding) {
  const PictureMotion& motion = finding.together->motion;
  return fmt::format(
      "all cameras moved together against {}, or it against them, by {:.2f} px at the object (sigma {:.2f})",
      input.positioner_name, motion.moved_px, motion.sigma_px);
}

std::string OkText(const DriftFinding& finding) {
  const CameraDrift& largest = Largest(finding);
  return fmt::format("no camera moved by more than {:.2f} px at the object; {} by {}", finding.limit_px, largest.camera,
                     MotionText(largest.motion));
}

std::string ReasonsText(const DriftFinding& finding) {
  std::vector<std::string> parts;
  for (const DriftReason& reason : finding.reasons) parts.push_back(ReasonText(reason));
  return Joined(parts, "; ");
}

}  // namespace

const char* NameOf(DriftState state) {
  switch (state) {
    case DriftState::kOk:
      return "ok";
    case DriftState::kDrifting:
      return "drifting";
    case DriftState::kFailed:
      return "failed";
    case DriftState::kInconclusive:
      break;
  }
  return "inconclusive";
}

std::string ReasonText(const DriftReason& reason) {
  const std::string unit = reason.unit.empty() ? "" : " " + reason.unit;
  return fmt::format("{}{}: {:.3g}{} against a limit of {:.3g}{}", reason.check,
                     reason.camera ? " (" + *reason.camera + ")" : "", reason.value, unit, reason.limit, unit);
}

std::vector<std::string> SentencesOf(const DriftInput& input, const DriftFinding& finding) {
  std::vector<std::string> parts;
  if (!finding.suspects.empty())
    parts.push_back(finding.which_is_told ? MovedText(finding) : SuspectsText(input, finding));
  if (finding.together && finding.together->moved) parts.push_back(TogetherText(input, finding));
  parts.insert(parts.end(), input.slips.begin(), input.slips.end());
  if (finding.state == DriftState::kOk) {
    parts.push_back(OkText(finding));
  } else if (finding.state == DriftState::kInconclusive || parts.empty()) {
    parts.push_back(ReasonsText(finding));
  }
  std::vector<std::string> sentences = {fmt::format("{}: {}", NameOf(finding.state), Joined(parts, "; "))};
  sentences.insert(sentences.end(), input.notes.begin(), input.notes.end());
  return sentences;
}

}  // namespace rigcal
