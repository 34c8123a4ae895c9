// See tremor.h. The generator is SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom
// number generators", OOPSLA 2014).
#include "device/simulated/tremor.h"

#include <cmath>

#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Frequencies lie within this share of the centre.
constexpr double kHalfBand = 0.2;
/// 2^64 and a turn in units of it.
constexpr double kTurn = 0x1p64;

std::uint64_t next_bits(std::uint64_t& state) noexcept {
  state += 0x9e3779b97f4a7c15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31U);
}

}  // namespace

Tremor::Tremor(std::uint64_t seed, double rms, double frequency, double period) noexcept
    // 3 axes of kSinusoids sinusoids of amplitude a have the mean square 3 kSinusoids a^2 / 2.
    : amplitude_(rms * std::sqrt(2.0 / (3.0 * kSinusoids))) {
  std::uint64_t state = seed;
  for (auto& axis : axes_) {
    for (std::size_t i = 0; i < kSinusoids; ++i) {
      // One frequency in each of equal parts of the band, so that they never coincide.
      const double share = static_cast<double>(next_bits(state) >> 11U) * 0x1p-53;
      const double place = (static_cast<double>(i) + share) / kSinusoids;
      const double turns = frequency * (1.0 - kHalfBand + 2.0 * kHalfBand * place) * period;
      axis[i].increment = static_cast<std::uint64_t>((turns - std::floor(turns)) * kTurn);
      axis[i].phase = next_bits(state);
    }
  }
}

Vector3 Tremor::next() noexcept {
  Vector3 displacement{0.0, 0.0, 0.0};
  if (amplitude_ == 0.0) return displacement;
  for (std::size_t k = 0; k < 3; ++k) {
    double sum = 0.0;
    for (Oscillator& oscillator : axes_[k]) {
      oscillator.phase += oscillator.increment;
      const double turns = static_cast<double>(oscillator.phase >> 11U) * 0x1p-53;
      sum += sin_cos(2.0 * kPi * turns).sin;
    }
    displacement[static_cast<Eigen::Index>(k)] = amplitude_ * sum;
  }
  return displacement;
}

}  // namespace hapticd
