#pragma once

#include <vector>

namespace rigcal {

/// Middle of the values (the upper one of two); 0 without any.
double Median(std::vector<double> values);

}  // namespace rigcal
