#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/execution.h"
#include "sim_fixtures/render.h"
#include "sim_fixtures/studio.h"

namespace rigcal::sim {

/// How a studio's pictures were taken.
struct ShotOptions {
  int samples_per_side = 3;
  SensorOptions sensor;
};

/// The text of truth.json: the options of the studio and its pictures, and the true cameras, poses and table angles; of
/// a chart also its shape and place and the poses in which it was held.
std::string TruthText(const Studio& studio, const ShotOptions& shot);

/// The studio of a truth.json, made again from its options; `file` names it in messages. Errors: kBadInput (also when
/// this version of the studio puts its cameras elsewhere than the file says, and for a studio with a chart),
/// kCancelled.
Result<Studio> StudioFromTruth(std::string_view text, const std::string& file, const Execution& execution);

}  // namespace rigcal::sim
