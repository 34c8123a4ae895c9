// Numbers nobody would send on purpose, for property tests of the safety stage: NaN of both kinds,
// infinities, the largest and smallest doubles, denormals, sign flips, and ordinary ones between.
#pragma once

#include <cmath>
#include <limits>

#include "core/math/vector.h"
#include "tests/support/random.h"

namespace hapticd::test {

/// A finite number of any size, about `scale` in half of all cases.
inline double wild(SplitMix64& random, double scale) {
  using Limits = std::numeric_limits<double>;
  switch (random.below(16)) {
    case 0:
      return 0.0;
    case 1:
      return -0.0;
    case 2:
      return Limits::max() * (random.chance(0.5) ? 1.0 : -1.0);
    case 3:
      return Limits::denorm_min() * static_cast<double>(random.below(1000));
    case 4:
      return -Limits::min();
    case 5:
      return scale * 1e150 * random.uniform(-1.0, 1.0);
    case 6:
      return scale * 1e-160 * random.uniform(-1.0, 1.0);
    case 7:
      return scale * 1e6 * random.uniform(-1.0, 1.0);
    default:
      return scale * random.uniform(-1.0, 1.0);
  }
}

/// One of the values that are no numbers.
inline double no_number(SplitMix64& random) {
  using Limits = std::numeric_limits<double>;
  switch (random.below(4)) {
    case 0:
      return Limits::quiet_NaN();
    case 1:
      return Limits::signaling_NaN();
    case 2:
      return Limits::infinity();
    default:
      return -Limits::infinity();
  }
}

inline Vector3 wild_vector(SplitMix64& random, double scale) {
  if (random.chance(0.7)) return to_vector(random.direction()) * (scale * random.uniform());
  return {wild(random, scale), wild(random, scale), wild(random, scale)};
}

}  // namespace hapticd::test
