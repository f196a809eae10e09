#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace rigcal {

/// Reproducible random numbers: the standard's engine, but distributions of our own, because the standard leaves theirs
/// to the library. The same seed gives the same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// In [0, 1), 53 random bits.
  double Uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// Standard normal (Box-Muller).
  double Normal();
  /// In [0, count); count > 0.
  std::size_t Index(std::size_t count) { return static_cast<std::size_t>(Uniform() * static_cast<double>(count)); }
  /// Fisher-Yates.
  template <typename T>
  void Shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[Index(i)]);
  }

 private:
  std::mt19937_64 engine_;
};

/// A seed for a sub-task, so that its numbers do not depend on how many numbers others drew (splitmix64 of both).
std::uint64_t DeriveSeed(std::uint64_t seed, std::uint64_t task);

}  // namespace rigcal
