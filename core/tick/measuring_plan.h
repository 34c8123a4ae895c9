// How the measuring of a device's damping runs: a spring about the place where it began pulls the
// handle aside and lets it ring, to either side and with two stiffnesses, since one alone cannot
// tell a mass from a hand that holds on. Plain data, for who makes the force and who judges it.
// RT: yes.
#pragma once

#include "core/tick/push_axis.h"

namespace hapticd {

/// Rings: both stiffnesses to the one side, then to the other.
inline constexpr int kRings = 4;
/// Of each ring: the pull grows, s. Shorter: it shakes the handle before it is let go.
inline constexpr double kPullRamp_s = 0.2;
/// Then lasts, until the handle is at rest, s.
inline constexpr double kPullHold_s = 0.3;
/// Then it rings, s. Longer: heavy handles ring more often; shorter: less to wait for.
inline constexpr double kRingFree_s = 1.2;
/// A ring with its pull, s.
inline constexpr double kRing_s = kPullRamp_s + kPullHold_s + kRingFree_s;
/// All of it, s.
inline constexpr double kMeasuring_s = kRings * kRing_s;
/// Share of the stiffness in every second ring.
inline constexpr double kSoftRing = 0.5;
/// The handle is pulled aside by so much at most, m. Larger: it gains energy that the port counts;
/// smaller: its encoder has too few steps of it.
inline constexpr double kMaxPull = 2.5e-3;
/// Farther from where it began somebody leads the handle, m.
inline constexpr double kMaxExcursion = 0.015;

/// Place of the axis of `axis`, which is none of 0, in x, y, z.
[[nodiscard]] constexpr int place_of(PushAxis axis) noexcept { return (axis - 1) / 2; }

}  // namespace hapticd
