// Keeps the root mean square of a force over every window (10 s) at what the motors hold for ever,
// c. Half of c^2 is always available, so that no force ever vanishes after a peak; what is written
// beyond it, integral (|F|^2 - c^2/2) dt, is added up in 64 blocks, never less than the true window
// holds, and may reach c^2/2 times the window. What is left is handed out so that it lasts
// kThermalHorizon_s at least: the bound comes as a fade, not as a cut. RT: yes, about 10 ns.
#pragma once

#include <array>

#include "core/math/realtime.h"

namespace hapticd {

/// Parts of the window. More: less too early a limit (the window is up to 1/64 too long).
inline constexpr int kThermalBlocks = 64;
/// Share of c^2 that is always available, [0, 1). Larger: shorter peaks; smaller: less is left
/// after them. At 0.5 22 N may stand for 0.33 s where c is 6 N, then 4.2 N until the window has
/// passed.
inline constexpr double kThermalFloor = 0.5;
/// Time for which the rest of the budget must last, s. Longer: a steady force stays further below
/// the continuous one (by 0.1 % at 0.05 s of 10 s); shorter than a few ticks: a cut.
inline constexpr double kThermalHorizon_s = 0.05;

/// What a device holds for ever.
struct ThermalRating {
  double continuous;  ///< root mean square over the window, N or N m, >= 0; infinite: no limit
  double window_s;    ///< > 0
};

/// Excess over the floor, N^2 s or (N m)^2 s.
struct ThermalLoad {
  std::array<double, kThermalBlocks> blocks{};  ///< complete blocks, a ring
  double current = 0.0;                         ///< of the block that runs
  double current_s = 0.0;                       ///< its length so far
  int oldest = 0;                               ///< in blocks
};

/// Adds `size` = |F| (>= 0) held for `dt_s` (>= 0) and forgets what left the window.
HD_REALTIME void add_load(double size, double dt_s, const ThermalRating& rating,
                          ThermalLoad& load) noexcept;

/// Largest |F| for now, so that the rating is kept while no tick is longer than kThermalHorizon_s.
[[nodiscard]] HD_REALTIME double allowed_size(const ThermalRating& rating,
                                              const ThermalLoad& load) noexcept;

}  // namespace hapticd
