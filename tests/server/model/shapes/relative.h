// Comparison of small numbers: doctest's Approx allows its epsilon times (1 + the number), so that
// lengths in m would hardly be compared at all. For tests; not RT.
#pragma once

#include <doctest/doctest.h>

namespace hapticd::test {

/// Equal to `value` within `tolerance` times the larger of the two; equals nothing when that is 0.
inline doctest::Approx relative(double value, double tolerance) {
  return doctest::Approx(value).epsilon(tolerance).scale(0.0);
}

}  // namespace hapticd::test
