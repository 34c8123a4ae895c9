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
#include "core/instrument/string_touch.h"
#include "core/math/limits.h"
#include "core/math/realtime.h"

namespace hapticd {

/// State of the modes of one string. Mode n (index n - 1) is q = amplitude decay cos(2 pi phase),
/// v = (dq/dt) / omega = -amplitude decay sin(2 pi phase), so that m omega^2 amplitude^2 / 2 is its
/// energy. Deviation: of a mode that decays freely, dq/dt lacks q / T_d (at 65 Hz and 0.5 s 0.5 %
/// of the largest speed); so energy is continuous when a finger comes or goes.
struct ModalString {
  int count = 0;  ///< N, 0 .. kMaxModes
  /// At t_ns, m, >= 0; decays from there by exp(-(t - t_ns) / decay).
  std::array<double, kMaxModes> amplitude{};
  /// Now, in units of 2^-64 turn: addition wraps, so nothing drifts.
  std::array<std::uint64_t, kMaxModes> phase{};
  std::int64_t t_ns = 0;
};

/// A string that was drawn aside and let go.
struct Pluck {
  double lambda = 0.5;
  double deflection = 0.0;   ///< m, either sign
  double unload_time = 0.0;  ///< s, >= 0: it was let go evenly over that time, ending at t_ns
  std::int64_t t_ns = 0;
};

/// A finger at lambda over a tick, pressing through a one-sided spring. Its far end (the hand)
/// moves evenly from displacement `D_before` to `D_after`: m, in the direction of w; negative:
/// clear of the resting string.
struct PressingFinger {
  double lambda = 0.5;
  double D_before = 0.0;
  double D_after = 0.0;
  double stiffness = 1000.0;  ///< N/m, > 0
  int steps = 1;              ///< contact steps the tick is cut into, clamped to [1, 4096]
};

/// What a finger felt over a tick. Passive: the energy of the modes and `stored` together grow by
/// no more than `work`, whatever the steps; undamped they grow by exactly that.
struct ModalTouch {
  /// Mean contact force of the string on the finger over the tick, N, >= 0.
  double force;
  /// Of the finger on the string, J: force times motion of the finger's far end.
  double work;
  /// Energy in the finger's spring and the compliance left out at the start and end of the tick, J.
  /// The start differs from the last tick's end only if the finger has jumped or slid in between.
  double stored_before;
  double stored;
};

/// The fundamental alone, as levels below this one know it.
struct Fundamental {
  double amplitude;     ///< at mid-span, m, >= 0
  std::uint64_t phase;  ///< 2^-64 turn, of a cosine
};

/// Amplitude of mode n of an ideal string drawn aside by `delta` at lambda and let go at once, m,
/// signed: 2 delta sin(n pi lambda) / (n^2 pi^2 lambda (1 - lambda)). 0 on the ends themselves,
/// which cannot be drawn aside.
[[nodiscard]] HD_REALTIME double pluck_amplitude(double lambda, double delta, int n) noexcept;

/// Compliance at lambda that `count` modes leave out, m/N: lambda (1 - lambda) L / T less the sum
/// of theirs; >= 0, 0 when slack. All of it for a string without tuning, which has no modes.
[[nodiscard]] HD_REALTIME double residual_compliance(const StringConstants& string, double lambda,
                                                     int count) noexcept;

/// Sets the modes to what `count` of them do after `pluck`: amplitude |pluck_amplitude sin(x)/x|,
/// x = pi f_n unload_time, phase as of a release at its middle. What rang before is gone: the
/// string was held. A stiff string's partials are smaller by (n f_1 / f_n)^2, as the same force
/// bends it. 30 ns per mode.
HD_REALTIME void pluck_modes(const StringConstants& string, const Pluck& pluck, int count,
                             ModalString& modes) noexcept;

/// Sets `count` modes of which only the fundamental moves: same displacement and energy.
HD_REALTIME void set_fundamental(const Fundamental& fundamental, int count, std::int64_t t_ns,
                                 ModalString& modes) noexcept;

/// Energy of the modes at time t_ns >= modes.t_ns, J: sum of m omega_n^2 A_n^2 / 2.
[[nodiscard]] HD_REALTIME double modal_energy(const StringConstants& string,
                                              const ModalString& modes, double decay,
                                              std::int64_t t_ns) noexcept;

/// Amplitudes of the modes relative to the largest, in [0, 1], 0 beyond the count. Returns the
/// count, 0 for a string at rest.
HD_REALTIME int relative_partials(const ModalString& modes,
                                  std::array<float, kMaxModes>& partials) noexcept;

/// One free tick: turns every phase by dt_ns in [0, 1e15], at the frequencies times `pitch` (1
/// without glide; (0, 10]). The amplitudes stay; they decay in closed form. 2 ns per mode.
HD_REALTIME void advance_free_modes(const StringConstants& string, double pitch, std::int64_t dt_ns,
                                    ModalString& modes) noexcept;

/// The tick `time` (dt_ns as above; 0: nothing moves) under a finger. Up to the start of the tick
/// the modes decay with string.decay, in it with string.touch_decay; modes.t_ns becomes t_ns. Modes
/// with a node at lambda do not feel the finger. A string that lost its tuning loses its modes.
/// tests/benchmark/string_table measures cost and accuracy.
HD_REALTIME ModalTouch touch_modes(const StringConstants& string, const PressingFinger& finger,
                                   const TickTime& time, ModalString& modes) noexcept;

}  // namespace hapticd
