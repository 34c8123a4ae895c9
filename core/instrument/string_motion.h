// A string as modes in two planes across it, w(lambda, t) = sum_n sin(n pi lambda) q_n(t), turned
// and decayed exactly from sub-step to sub-step whatever acts on it. Nothing else remembers what a
// string does: what it rings with after a pluck is what the finger left in it. Source: S. Bilbao,
// "Numerical Sound Synthesis", 2009, 3.1 and 6.1; N. H. Fletcher and T. D. Rossing, "The Physics
// of Musical Instruments", 2nd ed., 2.5-2.8. SI; the string lies along x. RT: yes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/instrument/string_parameters.h"
#include "core/math/limits.h"
#include "core/math/realtime.h"

namespace hapticd {

/// A number for each mode, in order; what lies beyond the count is 0. Aligned for four at a time.
struct alignas(32) PerMode : std::array<double, kMaxModes> {};

/// Sub-steps of a millisecond, where nothing else is asked for. Fewer: strings keep fewer modes,
/// and plucks are less exact; more: dearer in proportion.
inline constexpr int kSubSteps = 32;

/// The highest fundamental that has modes, Hz: four of them, each a quarter of a turn at most in
/// one of `substeps` sub-steps of a millisecond.
[[nodiscard]] constexpr double highest_wave_frequency(int substeps) noexcept {
  return 1000.0 / 16.0 * substeps;
}

/// Transverse the string, (y, z).
struct Transverse {
  double y = 0.0;
  double z = 0.0;
};

/// What the modes of a string are turned by in a sub-step.
struct ModeTable {
  int count = 0;        ///< a multiple of 4, 0: the string has no modes
  double step = 0.0;    ///< h, s
  PerMode stiffness{};  ///< K_n = m omega_n^2, N/m
  PerMode omega{};      ///< undamped, rad/s
  PerMode sigma{};      ///< of the decay, 1/s
  // q' = qq q + qv v, v' = vv v - qv q; a force P that is constant over the sub-step adds push_q
  // phi P and push_v phi P.
  PerMode qq{}, qv{}, vv{};
  PerMode push_q{}, push_v{};
};

/// How a string loses what it rings with: mode n decays by exp(-(1 / decay + n^2 loss_n2) t).
struct StringLoss {
  double decay = 0.5;      ///< s, > 0
  double loss_n2 = 0.002;  ///< 1/s, >= 0
};

/// The table of up to `modes` modes, in fours, for `substeps` sub-steps of a millisecond; fewer
/// modes where one would turn by more than a quarter of a turn in a sub-step: so what they leave
/// out of the string is soft enough, in series, that no contact is ever stiff for a sub-step. None
/// for a string without tuning, or above highest_wave_frequency(). 0.1 us per mode.
[[nodiscard]] HD_REALTIME ModeTable mode_table(const StringConstants& string,
                                               const StringLoss& loss, int modes,
                                               int substeps = kSubSteps) noexcept;

/// State of a string. Mode n (index n - 1) is q (m) and v = (dq/dt) / omega_n.
struct ModalMotion {
  PerMode qy{}, qz{}, vy{}, vz{};
};

/// sin(n pi lambda) of all modes, lambda in [0, 1]; within 1e-13.
HD_REALTIME void mode_shapes(const ModeTable& table, double lambda, PerMode& shapes) noexcept;

/// Displacement where the modes have these shapes, m.
[[nodiscard]] HD_REALTIME Transverse displacement(const ModeTable& table, const ModalMotion& motion,
                                                  const PerMode& shapes) noexcept;

/// What a unit force at `from` moves the string by at `to` in a sub-step, m/N.
[[nodiscard]] HD_REALTIME double response(const ModeTable& table, const PerMode& from,
                                          const PerMode& to) noexcept;

/// Where a string is, and how far a unit force there moves it in a sub-step.
struct PlaceOfString {
  Transverse u;           ///< m
  double response = 0.0;  ///< m/N
};

/// Moves a place along the string by `step` of its shapes, and reads the string there.
[[nodiscard]] HD_REALTIME PlaceOfString slide(const ModeTable& table, const ModalMotion& motion,
                                              const PerMode& step, PerMode& shapes) noexcept;

/// One sub-step without forces. Returns the displacement after it where the modes have these
/// shapes, m. 0.5 ns per mode.
HD_REALTIME Transverse turn(const ModeTable& table, const PerMode& shapes,
                            ModalMotion& motion) noexcept;

/// `steps` sub-steps without forces at once, in closed form; 40 ns per mode.
HD_REALTIME void turn_on(const ModeTable& table, std::int64_t steps, ModalMotion& motion) noexcept;

/// Adds what `force` (N) at `shapes` does over the sub-step that turn() has made.
HD_REALTIME void push(const ModeTable& table, const PerMode& shapes, const Transverse& force,
                      ModalMotion& motion) noexcept;

/// sum K_n (q^2 + v^2) / 2 of both planes, J.
[[nodiscard]] HD_REALTIME double energy(const ModeTable& table, const ModalMotion& motion) noexcept;

/// Compliance at lambda that the modes leave out, m/N, >= 0: in series with every contact.
[[nodiscard]] HD_REALTIME double residual_compliance(const StringConstants& string,
                                                     const ModeTable& table, double lambda,
                                                     const PerMode& shapes) noexcept;

}  // namespace hapticd
