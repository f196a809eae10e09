#pragma once

#include <string>

#include "config/calibration_file.h"
#include "config/calibration_store.h"
#include "tests/config/example_rig.h"

namespace rigcal {

/// A revision as a run leaves it, every field filled; `variant` makes its numbers differ.
inline CalibrationRevision ExampleRevision(const std::string& rig, int variant, Verdict verdict = Verdict::kAccepted) {
  RigCalibration ring = ExampleRing(3);
  ring.cameras[0].fx_px += variant / 7.0;
  CalibrationRevision revision;
  RevisionHead& head = revision.head;
  head.rig = rig;
  head.time = fmt::format("2026-01-31T23:{:02}:{:02}Z", variant / 60 % 60, variant % 60);
  head.verdict = verdict;
  if (verdict != Verdict::kAccepted) head.reasons = {"epipolar: 1.3 px against a limit of 1 px", "a \"quoted\" one"};
  head.origin.recording_id = fmt::format("night {}", variant);
  head.origin.recording_sha256 = std::string(64, 'a');
  head.origin.run = {.program_version = "0.1.0",
                     .method = "rigcal",
                     .options = {{"rounds", "4"}, {"poses", "rig"}},
                     .random_seed = 9223372036854775807U,
                     .inputs = {{"recording.json", std::string(64, 'a')}, {"seed.json", std::string(64, 'b')}},
                     .notes = {"a note"}};
  revision.calibration_text = CalibrationText(ring, head.origin.run);
  revision.report_text = fmt::format("{{\"format\": \"rigcal report\", \"variant\": {}}}\n", variant);
  return revision;
}

/// Asks for a revision as a person would; `expected` is in force.
inline PublishRequest ExampleRequest(const std::string& rig, int revision, std::optional<int> expected) {
  return {.rig = rig, .revision = revision, .expected = expected, .time = "2026-02-01T06:00:00Z", .by = "anna"};
}

}  // namespace rigcal
