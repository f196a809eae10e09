#pragma once

#include "core/adjust/bundle.h"

namespace rigcal {

/// Covariance of cameras, rig and stop errors from what the features say about intrinsics and poses (`features`, over
/// the free vector of terms.free) and the rig's priors; and that of the poses which follow from it.
void WriteRigPosterior(const Eigen::MatrixXd& features, const BundleTerms& terms, Adjustment& out);

}  // namespace rigcal
