#pragma once

#include "sim_fixtures/studio.h"

namespace rigcal::sim {

/// The view of a turntable studio's camera with the table commanded to any angle: the studio's own view where it stops
/// there (whole turns apart is the same angle), otherwise one that is added to it. The errors of a stop that is added
/// are drawn from the studio's seed and the angle alone, with the standard deviations of its options.
int ViewAt(Studio& studio, int camera, double commanded_rad);

}  // namespace rigcal::sim
