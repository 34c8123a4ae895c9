// A string as N modes (level L3): w(lambda, t) = sum_n sin(n pi lambda) q_n(t), displacement along
// the direction of the touch or pluck. Free modes rotate and decay exactly; a touched string is
// stepped against a one-sided finger of stiffness k, with the static compliance of the modes left out
// so that a slow press feels the full string. Source: N. H. Fletcher and T. D. Rossing, "The Physics
// of Musical Instruments", 2nd ed., 2.5-2.8; exact rotation: S. Bilbao, "Numerical Sound Synthesis",
// 3.1. SI. RT: yes.
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

}  // namespace hapticd
