// Random numbers by counter: number `index` of stream `stream`, the same whichever thread asks and
// in whatever order. Two rounds of the finaliser of SplitMix64 (Steele, Lea, Flood, "Fast
// splittable pseudorandom number generators", OOPSLA 2014). Offline.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/math/elementary.h"
#include "core/math/vector.h"

namespace hapticd {

/// 64 bits scrambled.
[[nodiscard]] constexpr std::uint64_t scrambled(std::uint64_t z) noexcept {
  z += 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31U);
}

/// Uniform in [0, 1), a multiple of 2^-53.
[[nodiscard]] constexpr double counter_uniform(std::uint64_t stream, std::uint64_t index) noexcept {
  return static_cast<double>(scrambled(scrambled(stream) ^ index) >> 11U) * 0x1p-53;
}

/// Uniform on the unit sphere; uses the numbers 2 index and 2 index + 1 of the stream.
[[nodiscard]] inline Vector3 counter_direction(std::uint64_t stream, std::uint64_t index) noexcept {
  const double z = 2.0 * counter_uniform(stream, 2 * index) - 1.0;
  const double around = std::sqrt(std::fmax(1.0 - z * z, 0.0));
  const SinCos angle = sin_cos(2.0 * kPi * counter_uniform(stream, 2 * index + 1));
  return {around * angle.cos, around * angle.sin, z};
}

}  // namespace hapticd
