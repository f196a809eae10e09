#pragma once

#include <Eigen/Core>

#include "config/json_content.h"

namespace rigcal {

/// A symmetric matrix by its rows that are not zero: what was held fixed is left out of the file. {"order", "rows",
/// "upper_triangle"}; `order` tells people what the rows are.
nlohmann::ordered_json CovarianceJson(const Eigen::MatrixXd& joint, const char* order);
/// The size x size matrix of that. Throws BadContent.
Eigen::MatrixXd CovarianceFrom(const nlohmann::ordered_json& json, Eigen::Index size);

}  // namespace rigcal
