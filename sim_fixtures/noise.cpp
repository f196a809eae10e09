#include "sim_fixtures/noise.h"

#include <algorithm>
#include <cmath>

#include "core/base/ensure.h"

namespace rigcal::sim {
namespace {

/// Standard deviation of one octave of GradientNoise below, measured over four million random places.
constexpr float kOctaveSigma = 0.191f;

inline std::uint32_t Hash(std::uint32_t x, std::uint32_t y, std::uint32_t z, std::uint32_t seed) {
  std::uint32_t h = (x * 0x8da6b343U) ^ (y * 0xd8163841U) ^ (z * 0xcb1ab31fU) ^ seed;
  h ^= h >> 15;
  h *= 0x2c1b3c6dU;
  h ^= h >> 12;
  h *= 0x297a2d39U;
  h ^= h >> 15;
  return h;
}

/// Inner product of a corner's pseudo-random gradient with the offset from that corner.
inline float Corner(std::uint32_t h, float dx, float dy, float dz) {
  constexpr float kScale = 1.0f / 511.5f;  // ten bits of the hash per component, to [-1, 1]
  const float gx = static_cast<float>(static_cast<std::int32_t>(h & 1023U)) * kScale - 1.0f;
  const float gy = static_cast<float>(static_cast<std::int32_t>((h >> 10) & 1023U)) * kScale - 1.0f;
  const float gz = static_cast<float>(static_cast<std::int32_t>((h >> 20) & 1023U)) * kScale - 1.0f;
  return gx * dx + gy * dy + gz * dz;
}

inline float Mix(float a, float b, float t) {
  return a + t * (b - a);
}

inline float Fade(float t) {
  return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
}

/// By truncation of a shifted value, which compiles to vector instructions; right for |x| < 8192.
inline std::int32_t Floor(float x) {
  constexpr std::int32_t kShift = 8192;
  return static_cast<std::int32_t>(x + static_cast<float>(kShift)) - kShift;
}

inline float GradientNoise(float x, float y, float z, std::uint32_t seed) {
  const std::int32_t floor_x = Floor(x), floor_y = Floor(y), floor_z = Floor(z);
  const float dx = x - static_cast<float>(floor_x);
  const float dy = y - static_cast<float>(floor_y);
  const float dz = z - static_cast<float>(floor_z);
  const auto ix = static_cast<std::uint32_t>(floor_x);
  const auto iy = static_cast<std::uint32_t>(floor_y);
  const auto iz = static_cast<std::uint32_t>(floor_z);
  const float u = Fade(dx), v = Fade(dy), w = Fade(dz);
  const float c000 = Corner(Hash(ix, iy, iz, seed), dx, dy, dz);
  const float c100 = Corner(Hash(ix + 1, iy, iz, seed), dx - 1, dy, dz);
  const float c010 = Corner(Hash(ix, iy + 1, iz, seed), dx, dy - 1, dz);
  const float c110 = Corner(Hash(ix + 1, iy + 1, iz, seed), dx - 1, dy - 1, dz);
  const float c001 = Corner(Hash(ix, iy, iz + 1, seed), dx, dy, dz - 1);
  const float c101 = Corner(Hash(ix + 1, iy, iz + 1, seed), dx - 1, dy, dz - 1);
  const float c011 = Corner(Hash(ix, iy + 1, iz + 1, seed), dx, dy - 1, dz - 1);
  const float c111 = Corner(Hash(ix + 1, iy + 1, iz + 1, seed), dx - 1, dy - 1, dz - 1);
  return Mix(Mix(Mix(c000, c100, u), Mix(c010, c110, u), v), Mix(Mix(c001, c101, u), Mix(c011, c111, u), v), w);
}

/// Turns the lattice from octave to octave, so that the zeros of gradient noise at lattice points do not line up.
inline void Turn(float& x, float& y, float& z) {
  const float tx = 0.36f * x + 0.48f * y - 0.80f * z;
  const float ty = -0.80f * x + 0.60f * y;
  const float tz = 0.48f * x + 0.64f * y + 0.60f * z;
  x = tx, y = ty, z = tz;
}

}  // namespace

void EvaluateNoise(const FractalNoise& noise, const PlacesInWorld& places, std::span<float> values) {
  const std::size_t count = values.size();
  Ensure(places.x_m.size() == count && places.y_m.size() == count && places.z_m.size() == count,
         "as many coordinates as values");
  float power = 0, octave_power = 1;
  for (int octave = 0; octave < noise.num_octaves; ++octave, octave_power *= noise.gain * noise.gain) {
    power += octave_power;
  }
  const float first = 1.0f / (kOctaveSigma * std::sqrt(power));
  constexpr std::size_t kBlock = 256;
  float x[kBlock], y[kBlock], z[kBlock];
  for (std::size_t start = 0; start < count; start += kBlock) {
    const std::size_t n = std::min(kBlock, count - start);
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = places.x_m[start + i] / noise.longest_m;
      y[i] = places.y_m[start + i] / noise.longest_m;
      z[i] = places.z_m[start + i] / noise.longest_m;
    }
    float* out = values.data() + start;
    std::fill(out, out + n, 0.0f);
    float amplitude = first;
    for (int octave = 0; octave < noise.num_octaves; ++octave, amplitude *= noise.gain) {
      const std::uint32_t seed = (noise.seed + static_cast<std::uint32_t>(octave)) * 0x9e3779b9U;
      for (std::size_t i = 0; i < n; ++i) {
        out[i] += amplitude * GradientNoise(x[i], y[i], z[i], seed);
        x[i] *= 2, y[i] *= 2, z[i] *= 2;
        Turn(x[i], y[i], z[i]);
      }
    }
  }
}

float NoiseAt(const FractalNoise& noise, float x_m, float y_m, float z_m) {
  float value = 0;
  EvaluateNoise(noise, {{&x_m, 1}, {&y_m, 1}, {&z_m, 1}}, {&value, 1});
  return value;
}

}  // namespace rigcal::sim
