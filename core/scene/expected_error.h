#pragma once

namespace rigcal {

/// The pyramid level for an expected reprojection error Er in full-size pixels: L = max(0, floor(log2 Er)), where
/// features lie within about two pixels of their points (paper section 3.1, Fig. 2 and Table 1: 12 -> 3, 8 -> 3, 7 ->
/// 2, 5 -> 2).
int PyramidLevel(double expected_error_px);

}  // namespace rigcal
