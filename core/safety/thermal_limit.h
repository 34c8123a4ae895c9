// Keeps the root mean square of a force over a sliding window (10 s) below what the motors hold for
// ever. Book-keeping of integral |F|^2 dt in 64 blocks, never less than the true window holds. What
// is left is handed out so that it lasts kThermalHorizon_s at least: the bound comes as a slow
// fade, not as a cut. RT: yes, about 5 ns.
#pragma once

#include <array>

#include "core/math/realtime.h"

namespace hapticd {

/// Parts of the window. More: less too early a limit (the window is up to 1/64 too long).
inline constexpr int kThermalBlocks = 64;
/// Time for which the rest of the budget must last, s. Longer: a steady force stays further below
/// the continuous one (by 1.2 % at 0.25 s of 10 s); shorter than a few ticks: a cut.
inline constexpr double kThermalHorizon_s = 0.25;

/// Squares of what was written, N^2 s or (N m)^2 s.
struct ThermalLoad {
  std::array<double, kThermalBlocks> blocks{};  ///< complete blocks, a ring
  double current = 0.0;                         ///< of the block that runs
  double current_s = 0.0;                       ///< its length so far
  int oldest = 0;                               ///< in blocks
};

/// Adds `size` = |F| (>= 0) held for `dt_s` (>= 0) and forgets what left the window of `window_s`.
HD_REALTIME void add_load(double size, double dt_s, double window_s, ThermalLoad& load) noexcept;

/// Largest |F| for now, so that the root mean square over any window stays at most `continuous`
/// (> 0) while no tick is longer than kThermalHorizon_s.
[[nodiscard]] HD_REALTIME double allowed_size(double continuous, double window_s,
                                              const ThermalLoad& load) noexcept;

}  // namespace hapticd
