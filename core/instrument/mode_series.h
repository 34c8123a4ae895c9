// Frequencies, shapes and phases of the modes of a string, as those who play strings share
// them. Turns are reduced before they become angles, so sin_cos stays in its range for every
// frequency and time. SI. RT: yes, inline.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/instrument/string_parameters.h"
#include "core/math/elementary.h"

namespace hapticd {

inline constexpr double kSecondsPerNanosecond = 1e-9;

/// Adding and subtracting this rounds to the nearest integer, for |x| <= 2^51: floor() is a call on
/// processors without SSE4.1.
inline constexpr double kToInteger = 0x1.8p52;

[[nodiscard]] inline double nearest_integer(double x) noexcept {
  return (x + kToInteger) - kToInteger;
}

/// f_n = n base sqrt(1 + B n^2), with base = f_1 / sqrt(1 + B), so that no mode costs a division.
struct ModeSeries {
  double base;           ///< Hz
  double inharmonicity;  ///< B

  [[nodiscard]] double frequency(int n) const noexcept {
    const double number = n;
    return number * base * std::sqrt(1.0 + inharmonicity * (number * number));
  }
};

[[nodiscard]] inline ModeSeries mode_series(const StringConstants& string) noexcept {
  return {string.frequency / std::sqrt(1.0 + string.inharmonicity), string.inharmonicity};
}

/// m omega_n^2, N/m.
[[nodiscard]] inline double modal_stiffness(const StringConstants& string,
                                            double frequency) noexcept {
  const double omega = 2.0 * kPi * frequency;
  return string.modal_mass * omega * omega;
}

/// sin(pi h), |h| <= 2^51: exactly 0 at the integers.
[[nodiscard]] inline double sin_half_turns(double h) noexcept {
  const double whole = nearest_integer(h);
  const double s = sin_cos(kPi * (h - whole)).sin;
  const double half = 0.5 * whole;
  return half == nearest_integer(half) ? s : -s;
}

/// sin(n pi lambda), as exact close to lambda = 1 as close to 0.
[[nodiscard]] inline double mode_shape(int n, double lambda) noexcept {
  if (lambda <= 0.5) return sin_half_turns(n * lambda);
  const double mirrored = sin_half_turns(n * (1.0 - lambda));
  return n % 2 == 0 ? -mirrored : mirrored;
}

/// The fraction of `turns`, |turns| <= 2^51, in units of 2^-64 turn. Through 2^63, which the
/// fraction in [-1/2, 1/2] cannot overflow.
[[nodiscard]] inline std::uint64_t phase_of_turns(double turns) noexcept {
  const double fraction = turns - nearest_integer(turns);
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(fraction * 0x1p63)) << 1U;
}

/// In [-1/2, 1/2].
[[nodiscard]] inline double turns_of_phase(std::uint64_t phase) noexcept {
  return static_cast<double>(static_cast<std::int64_t>(phase)) * 0x1p-64;
}

/// exp(-dt / decay), 1 exactly for dt <= 0: a time that steps back must not make anything grow.
[[nodiscard]] inline double decay_over(std::int64_t dt_ns, double decay) noexcept {
  if (dt_ns <= 0) return 1.0;
  return exponential(-(static_cast<double>(dt_ns) * kSecondsPerNanosecond) / decay);
}

}  // namespace hapticd
