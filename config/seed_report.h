#pragma once

#include <string>
#include <vector>

#include "core/seed/detect_chart.h"
#include "core/seed/seed_cameras.h"

namespace rigcal {

/// What report.json of a seed says (docs/schema/seed_report.schema.json). `detections` has one entry per view of the
/// scene. A number that is not finite becomes null.
std::string SeedReportText(const SeedScene& scene, const std::vector<ChartDetection>& detections,
                           const SeedResult& seed);

/// The same in a few lines, for people.
std::string SeedSummaryText(const SeedScene& scene, const SeedResult& seed);

}  // namespace rigcal
