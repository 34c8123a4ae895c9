// The spring a device renders by itself while it holds a command, where it offers to (affine
// command): f = f0 + K (p_ref - p), t = t0 + Kr e about the pose the command was computed from, at
// the rate of its own servo. What the loop renders then neither ages by the delay nor stays
// constant between two ticks. Granted only for a wrench that nothing has limited, and so softly
// that until the next command it can neither turn the force round nor take it past a limit. The
// observer of the port goes by f0: K is symmetric and positive semidefinite, and gives nothing over
// a cycle. Frames: D. RT: yes, about 10 ns.
#pragma once

#include <array>

#include "core/math/realtime.h"
#include "core/math/spring.h"
#include "core/safety/output_stage.h"

namespace hapticd {

/// Upper bound of the stiffness of `K` along any direction, N/m: its largest sum over a row.
[[nodiscard]] HD_REALTIME double row_bound(const std::array<double, 6>& K) noexcept;

/// What a spring may be granted on.
struct SpringContext {
  SafetyOutput written;  ///< of this tick
  double gain = 0.0;     ///< of the loop's ramp
  Twist V_DH_D;          ///< measured
  /// From the sample to the last instant at which the command is to hold, s.
  double horizon_s = 0.0;
  WrenchLimits peak;
  double stiffness_max = 0.0;  ///< the maker's promise, N/m; infinite: none
};

/// The part of `wanted` that is granted: scaled as a whole, translation and rotation apart, so that
///   - its row bound is at most stiffness_max,
///   - over the horizon the hand at its present speed changes the force by no more than there is,
///     than is left below the peak, and than the slew lets it grow; likewise the torque.
/// None at all unless the wrench is enabled at full gain and nothing has limited it, and where a
/// number is not finite, a diagonal entry negative, an entry beyond 1e9, or K would push along some
/// way: an eigenvalue below -1e-6 of the largest entry.
[[nodiscard]] HD_REALTIME DeviceSpring grant_spring(const DeviceSpring& wanted,
                                                    const SpringContext& context) noexcept;

}  // namespace hapticd
