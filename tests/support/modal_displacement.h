// What a string of modes does at a place, to be held against truths.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/instrument/modal_string.h"
#include "core/instrument/mode_series.h"
#include "core/math/elementary.h"

namespace hapticd::test {

/// w at lambda now, which is t_ns, m.
[[nodiscard]] inline double modal_displacement(const ModalString& modes, double lambda,
                                               double decay, std::int64_t t_ns) {
  double w = 0.0;
  for (int n = 1; n <= modes.count; ++n) {
    const auto k = static_cast<std::size_t>(n - 1);
    const double cosine = sin_cos(2.0 * kPi * turns_of_phase(modes.phase[k])).cos;
    w += mode_shape(n, lambda) * (modes.amplitude[k] * cosine);
  }
  return w * decay_over(t_ns - modes.t_ns, decay);
}

}  // namespace hapticd::test
