// The fundamental of a released string (Eq. 9): a(t) = r exp(-t / T_d) sin(2 pi f t), t from the
// release, displacement along the touch normal, towards the tool. Its energy E = pi^2 T r^2 / (4 L)
// is what is kept: it decays in closed form from an anchor, so neither the number of ticks nor
// their length matters, and work taken out by a finger lowers it. Deviation: f is the string's
// tuning, and the phase is accumulated in turns that wrap, where the paper takes the sine of a
// growing t. SI. RT: yes.
#pragma once

#include <cstdint>

#include "core/instrument/string_parameters.h"
#include "core/math/realtime.h"

namespace hapticd {

/// State of the vibration of one string at t_ns. All zero: silent.
struct Vibration {
  double energy = 0.0;           ///< E, J
  double amplitude = 0.0;        ///< r: of a fundamental with that energy, m
  double released_energy = 0.0;  ///< E0: E when it was released, J
  double lambda = 0.5;           ///< where it was released
  double decay = 0.0;            ///< T_d of the amplitude, s
  std::uint64_t phase = 0;       ///< f t in units of 2^-64 turn
  std::int64_t t_ns = 0;
  double anchor_energy = 0.0;  ///< E = anchor_energy exp(-2 (t_ns - anchor_ns) / T_d)
  std::int64_t anchor_ns = 0;
};

/// E of a fundamental of amplitude r >= 0 (m), J.
[[nodiscard]] HD_REALTIME double fundamental_energy(const StringConstants& string,
                                                    double amplitude) noexcept;

/// r of a fundamental with energy E >= 0 (J), m; 0 when the string is slack or has no length.
[[nodiscard]] HD_REALTIME double fundamental_amplitude(const StringConstants& string,
                                                       double energy) noexcept;

/// The vibration with `energy` (J) of a string released at lambda and t_ns, with its free decay.
[[nodiscard]] HD_REALTIME Vibration start_vibration(const StringConstants& string, double energy,
                                                    double lambda, std::int64_t t_ns) noexcept;

/// E at t_ns, J: closed form, relative error <= 1e-15 (1 + 2 (t_ns - anchor_ns) / T_d). Before the
/// anchor: E there.
[[nodiscard]] HD_REALTIME double energy_at(const Vibration& vibration, std::int64_t t_ns) noexcept;

/// Sets E at the vibration's present time, J, >= 0.
HD_REALTIME void set_energy(const StringConstants& string, double energy,
                            Vibration& vibration) noexcept;

/// Sets T_d from the vibration's present time on, s, > 0. No change, no new anchor.
HD_REALTIME void set_decay(double decay, Vibration& vibration) noexcept;

/// Advances to t_ns; an earlier one does nothing. With `glide` the frequency is f_1 pitch_factor()
/// of the envelope where it was released, averaged between the beginning and the end. 20 ns, twice
/// that with glide.
HD_REALTIME void advance_vibration(const StringConstants& string, bool glide, std::int64_t t_ns,
                                   Vibration& vibration) noexcept;

/// a, m, at the place of the release.
[[nodiscard]] HD_REALTIME double displacement(const Vibration& vibration) noexcept;

/// phi: displacement at lambda over that at the place of the release, by the shape of the
/// fundamental, at most 1.
[[nodiscard]] HD_REALTIME double shape_factor(const Vibration& vibration, double lambda) noexcept;

/// k_v: what a metre of a is worth in newtons at lambda: k0 there, at most kc. N/m.
[[nodiscard]] HD_REALTIME double vibration_stiffness(const StringConstants& string,
                                                     double lambda) noexcept;

}  // namespace hapticd
