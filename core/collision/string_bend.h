// A string bent by a finger, as the collision stage sees it: its axis runs straight from A to the
// vertex P and on to B, P = A + lambda AB + u. Each leg is a capsule of the string's radius. RT:
// yes.
#pragma once

#include <cstdint>

#include "core/geometry/capsule.h"

namespace hapticd {

/// Where a string is bent to. With u = 0 it is straight, in two legs.
struct StringBend {
  std::int32_t capsule = 0;    ///< index among the capsules
  double lambda = 0.5;         ///< of the vertex, in [0, 1]
  Vector3 u_W{0.0, 0.0, 0.0};  ///< deflection of the vertex, m
};

/// Part of a string's axis: all of it, or a leg of a bent one.
struct AxisSegment {
  Capsule capsule_W;
  std::int32_t leg = 0;      ///< 0: the whole, or A to P; 1: P to B
  double lambda_from = 0.0;  ///< positions of the segment's ends along the string
  double lambda_to = 1.0;
};

/// Leg 0 or 1 of `string` bent by `bend`.
[[nodiscard]] inline AxisSegment leg_of(const Capsule& string, const StringBend& bend,
                                        std::int32_t leg) noexcept {
  const Vector3 p_P = string.p_A + bend.lambda * (string.p_B - string.p_A) + bend.u_W;
  if (leg == 0) return {{string.p_A, p_P, string.r}, 0, 0.0, bend.lambda};
  return {{p_P, string.p_B, string.r}, 1, bend.lambda, 1.0};
}

/// Position along the string of the place at `lambda` in [0, 1] of a segment.
[[nodiscard]] inline double string_lambda(const AxisSegment& segment, double lambda) noexcept {
  return segment.lambda_from + lambda * (segment.lambda_to - segment.lambda_from);
}

/// Share of the vertex's deflection that the string has at lambda: 1 at the vertex, 0 at the ends,
/// also while the vertex is there.
[[nodiscard]] inline double deflection_share(const StringBend& bend, double lambda) noexcept {
  if (lambda >= 1.0) return 0.0;
  if (lambda <= bend.lambda) return bend.lambda > 0.0 ? lambda / bend.lambda : 0.0;
  return (1.0 - lambda) / (1.0 - bend.lambda);
}

}  // namespace hapticd
