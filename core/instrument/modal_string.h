// A string as N modes (level L3): w(lambda, t) = sum_n sin(n pi lambda) q_n(t), displacement along
// the direction of the touch or pluck. Free modes rotate and decay exactly; a touched string is
// stepped against a one-sided finger of stiffness k, with the static compliance of the modes left
// out so that a slow press feels the full string. Source: N. H. Fletcher and T. D. Rossing, "The
// Physics of Musical Instruments", 2nd ed., 2.5-2.8; exact rotation: S. Bilbao, "Numerical Sound
// Synthesis", 3.1. SI. RT: yes.
#pragma once

#include <array>
#include <cstdint>

#include "core/instrument/string_parameters.h"
#include "core/math/limits.h"
#include "core/math/realtime.h"

namespace hapticd {

/// State of the modes of one string. Mode n (index n - 1) is q = amplitude decay cos(2 pi phase),
/// p = (dq/dt + q / T_d) / omega = -amplitude decay sin(2 pi phase).
struct ModalString {
  int count = 0;  ///< N, 0 .. kMaxModes
  /// At t_ns; decays from there by exp(-(t - t_ns) / decay).
  std::array<double, kMaxModes> amplitude{};
  /// In units of 2^-64 turn: addition wraps, so nothing drifts.
  std::array<std::uint64_t, kMaxModes> phase{};
  std::int64_t t_ns = 0;
};

/// What a finger felt over a tick.
struct ModalTouch {
  double force;  ///< mean contact force of the string on the finger over the tick, N, >= 0
  double work;   ///< by the finger on the string, J (force times motion of the finger's far end)
};

/// Amplitude of mode n of an ideal string drawn aside by `delta` at lambda and let go at once, m:
/// 2 delta sin(n pi lambda) / (n^2 pi^2 lambda (1 - lambda)); its limit on the ends, where it is 0.
[[nodiscard]] HD_REALTIME double pluck_amplitude(double lambda, double delta, int n) noexcept;

/// Compliance at lambda that `count` modes leave out, m/N: lambda (1 - lambda) L / T less the sum
/// of theirs; >= 0, 0 when slack.
[[nodiscard]] HD_REALTIME double residual_compliance(const StringConstants& string, double lambda,
                                                     int count) noexcept;

/// Energy of the modes at time t_ns >= modes.t_ns, J.
[[nodiscard]] HD_REALTIME double modal_energy(const StringConstants& string,
                                              const ModalString& modes, double decay,
                                              std::int64_t t_ns) noexcept;

/// One free tick: turns every phase by dt_ns, at the frequencies times `pitch` (1 without glide).
/// The amplitudes stay; they decay in closed form. 2 ns per mode.
HD_REALTIME void advance_free_modes(const StringConstants& string, double pitch, std::int64_t dt_ns,
                                    ModalString& modes) noexcept;

/// One tick under a finger, whose far end (the hand) moves evenly from displacement `D_before` to
/// `D_after` (m, in the direction of w; negative: clear of the resting string) at lambda and
/// presses through a one-sided spring `stiffness` (N/m). `steps` contact steps per tick; the modes
/// decay with string.touch_decay, and t_ns becomes the end of the tick. Passive: what comes back
/// out of the modes was in them or put in by the finger.
HD_REALTIME ModalTouch touch_modes(const StringConstants& string, double lambda, double D_before,
                                   double D_after, double stiffness, int steps, std::int64_t t_ns,
                                   std::int64_t dt_ns, ModalString& modes) noexcept;

}  // namespace hapticd
