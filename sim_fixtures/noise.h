#pragma once

#include <cstdint>
#include <span>

namespace rigcal::sim {

/// Solid (3-D) gradient noise in several octaves: the same value for the same place, from integer hashes alone.
struct FractalNoise {
  float longest_m = 0.016f;  ///< lattice spacing of the first octave; every further octave halves it
  int num_octaves = 1;
  float gain = 0.5f;  ///< amplitude of an octave relative to the one before
  std::uint32_t seed = 0;
};

/// Places, one coordinate per array, all of one length: the layout in which the compiler makes vectors of the loop.
struct PlacesInWorld {
  std::span<const float> x_m, y_m, z_m;
};

/// The noise at every place, scaled so that its standard deviation over space is about one whatever the octaves.
void EvaluateNoise(const FractalNoise& noise, const PlacesInWorld& places, std::span<float> values);

/// The same at one place.
float NoiseAt(const FractalNoise& noise, float x_m, float y_m, float z_m);

}  // namespace rigcal::sim
