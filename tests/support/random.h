// Seeded random numbers for tests: SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom
// number generators", OOPSLA 2014). The same seed gives the same bits on every compiler and CPU,
// which the std distributions do not promise. Needs no libm but sqrt. Not for the product: tests
// and benchmarks only.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace hapticd::test {

class SplitMix64 {
 public:
  explicit constexpr SplitMix64(std::uint64_t seed) noexcept : state_(seed) {}

  /// Next 64 uniform bits. Period 2^64.
  constexpr std::uint64_t next() noexcept {
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31U);
  }

  /// Uniform in [0, 1), a multiple of 2^-53.
  constexpr double uniform() noexcept { return static_cast<double>(next() >> 11U) * 0x1p-53; }

  /// Uniform in [low, high]; low <= high, both finite.
  constexpr double uniform(double low, double high) noexcept {
    return low + (high - low) * uniform();
  }

  /// Uniform integer in [0, count); count >= 1. The bias is below count / 2^64.
  constexpr std::uint64_t below(std::uint64_t count) noexcept { return next() % count; }

  /// True with the given probability in [0, 1].
  constexpr bool chance(double probability) noexcept { return uniform() < probability; }

  /// Uniform on the unit sphere in 3-D: rejection from the cube, about 2 tries.
  std::array<double, 3> direction() noexcept {
    for (;;) {
      const double x = uniform(-1.0, 1.0);
      const double y = uniform(-1.0, 1.0);
      const double z = uniform(-1.0, 1.0);
      const double length_squared = x * x + y * y + z * z;
      if (length_squared > 1e-6 && length_squared <= 1.0) {
        const double length = std::sqrt(length_squared);
        return {x / length, y / length, z / length};
      }
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace hapticd::test
