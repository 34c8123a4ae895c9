// What equations of rings say together: least squares, and how far off that may be. Neighbouring
// windows share samples and encoder steps are no white noise, so the errors are reckoned from what
// is left unexplained with its correlation (Newey and West 1987), not from its size alone. SI.
// Not RT.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "device/attach/ring_equations.h"

namespace hapticd {

struct RingSolution {
  RingVector p = RingVector::Zero();      ///< by RingUnknown
  RingVector error = RingVector::Zero();  ///< standard errors, 0 where given
  double residual = 0.0;                  ///< share of the forces that is not explained, [0, 1]
};

/// Unknowns that are not to be found but given.
using RingGiven = std::array<std::optional<double>, kRingUnknowns>;

/// Of `rings` together; none: they do not tell all unknowns that `given` leaves.
[[nodiscard]] std::optional<RingSolution> solve(std::span<const RingEquations* const> rings,
                                                const RingGiven& given);

}  // namespace hapticd
