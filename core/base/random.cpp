#include "core/base/random.h"

#include <cmath>
#include <numbers>

namespace rigcal {

double Random::Normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * Uniform());
}

std::uint64_t DeriveSeed(std::uint64_t seed, std::uint64_t task) {
  std::uint64_t z = seed + 0x9e3779b97f4a7c15ULL * (task + 1);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace rigcal
