// Numbers compared by a share of themselves. doctest's own Approx adds 1 to what its share is of:
// of a radius of a millimetre a thousandth would be a hundred per cent.
#pragma once

#include <doctest/doctest.h>

#include <limits>

namespace hapticd::test {

/// `value == within(truth, share)` where they differ by less than `share` (> 0) of the larger. Of 0
/// only 0 is: ask for a distance there.
[[nodiscard]] inline doctest::Approx within(double truth, double share) {
  return doctest::Approx(truth).epsilon(share).scale(std::numeric_limits<double>::min());
}

}  // namespace hapticd::test
