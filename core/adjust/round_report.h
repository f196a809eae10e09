#pragma once

#include "core/adjust/adjust.h"
#include "core/adjust/fit_quality.h"

namespace rigcal {

/// Fills what the report says about the fit, per view and over all, from the features that were kept; and each view's
/// next Er (paper section 3.3: mean + 3 sigma) within the bounds of the options: floored, never larger than it was, and
/// unchanged for a view with few features. With options.paper it is one number for all views, unbounded.
void ReportFit(const FitResiduals& residuals, const MeasurementSet& measurements,
               const std::vector<double>& expected_error_px, const AdjustOptions& options, AdjustReport& report);

}  // namespace rigcal
