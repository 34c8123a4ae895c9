// Largest stiffness that a device renders stably: half of (b + B) / (T/2 + t_d), hands off being
// the worst case (Colgate and Schenkel 1997, "Passivity of a class of sampled-data systems", with
// the delay added to the hold). One factor scales kt, kr, kc and k_v together, so that a clamped
// world is softer, not different. What is not stated of a device is not 0: it leaves the bound to
// what is. Also the estimate of the delay t_d from measured times. SI. RT: yes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/math/realtime.h"

namespace hapticd {

/// Share of the stable stiffness that is granted. Nearer to 1: contact rings with hands off.
inline constexpr double kStiffnessShare = 0.5;

/// Damping of a device of which neither that nor a stiffness is known, N s/m: that of the least
/// damped handles. Larger: such a device may ring; smaller: it gives no force to speak of.
inline constexpr double kMinDamping = 0.1;

/// Stiffness of a device whose damping is a guess, N/m, at 1 kHz without delay: what any handle
/// bears. Larger: one with little damping rings; smaller: nothing to feel until it is measured.
inline constexpr double kUnknownStiffness = 200.0;
/// Half of the period that kUnknownStiffness is for, s: with more between two samples, and a delay,
/// it is less by as much.
inline constexpr double kUnknownLag_s = 0.5e-3;

/// What the device can bear; profile data, except the delay and the period.
struct StiffnessLimits {
  double damping = 1.0;                 ///< b of the device, N s/m; 0: unknown
  bool damping_guessed = false;         ///< nobody measured it: it counts as an unknown device's
  double report_interval_s = 0.0;       ///< from sample to sample of the device
  double rotational_damping = 1e-3;     ///< of the device, N m s/rad; 0: no limit to rotation
  double coupling_damping = 0.0;        ///< B, N s/m
  std::optional<double> stiffness_max;  ///< the maker's promise, N/m; empty: none was given
  double period_s = 1e-3;               ///< T
  double delay_s = 0.0;                 ///< t_d from sample to force
  bool delay_unknown = false;           ///< until one is measured, delay_s > 0
};

/// Stiffness as the device feels it: translational ones times workspace scale and force gain, the
/// rotational one times force gain.
struct DeviceStiffness {
  double kt = 0.0;  ///< N/m
  double kr = 0.0;  ///< N m/rad
  double kc = 0.0;  ///< N/m
  double kv = 0.0;  ///< N/m
};

/// What is granted.
struct StiffnessGrant {
  double scale = 1.0;             ///< on kt, kr, kc and k_v, (0, 1]
  double bound = 0.0;             ///< largest translational stiffness granted, N/m
  double rotational_bound = 0.0;  ///< N m/rad; infinite when the rotational damping is unknown
};

/// The largest scale at which no stiffness exceeds its bound. The bound is half of
/// (b + B) / (T/2 + t_d), and no more than the maker's promise. Where b is unknown it is half of
/// B / (T/2 + t_d) or half of the promise, whichever is more; without a promise b counts as
/// kMinDamping. Where b is a guess it is that of an unknown device (kUnknownStiffness), the longer
/// of T and the report interval counting, and no more than half of the promise. Stiffnesses that
/// are not finite or negative give the smallest scale, kMinStiffnessScale.
[[nodiscard]] HD_REALTIME StiffnessGrant grant_stiffness(const DeviceStiffness& wanted,
                                                         const StiffnessLimits& limits) noexcept;

/// What is granted to a device whose damping is a guess, whether that of `limits` is one or not,
/// N/m.
[[nodiscard]] HD_REALTIME double unknown_bound(const StiffnessLimits& limits) noexcept;

/// A scale is never below this: it must stay a positive number that can be recorded and undone.
inline constexpr double kMinStiffnessScale = 1e-9;

/// Samples one estimate of the delay is made of.
inline constexpr int kDelaySamples = 256;
/// Of each kDelaySamples the estimate takes the sample of this rank, counted from the longest:
/// about the 99th percentile. A single late answer says nothing about the loop, a common one does.
inline constexpr int kDelayRank = 3;

/// Delay from sample to force as measured. Starts again at attach.
struct DelayEstimator {
  std::array<std::int64_t, kDelayRank> longest_ns{};  ///< of the present block, longest first
  int count = 0;                                      ///< samples of the present block
  std::int64_t estimate_ns = -1;                      ///< -1: not measured yet
};

/// Takes one measured delay, from the sample's time to the device's echo of the command made from
/// it, ns. The estimate never falls until a new attach: stiffness must not grow by itself under a
/// hand. Negative delays are ignored. True when the estimate changed.
[[nodiscard]] HD_REALTIME bool add_delay(std::int64_t delay_ns, DelayEstimator& estimator) noexcept;

/// The delay to reckon with, s: `declared_s` when time is virtual or nothing was measured, else the
/// measured one.
[[nodiscard]] HD_REALTIME double delay_of(const DelayEstimator& estimator, double declared_s,
                                          bool time_is_virtual) noexcept;

}  // namespace hapticd
