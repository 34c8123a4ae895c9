// How a debt at the port is paid. Once more energy has been given to the hand than a share of the
// allowance, whole wrenches shrink by a factor that changes slowly, falling while the wrench gives
// still more, and growing back while the hand puts in or nothing is owed. A scene whose forces have
// no potential (preset paper) so fades in the hand instead of letting go of it. Below half of the
// allowance there is no time for that: what points along the motion shrinks at once, by what share
// of the half is left. What must hold whatever the hand does is for the steps after it
// (passivity.h). RT: yes, 2 ns.
#pragma once

#include "core/math/realtime.h"

namespace hapticd {

/// Share of the allowance that may be owed before the wrench begins to shrink. Larger: less time to
/// fade before it must be cut; smaller: fast taps on stiff walls, which owe 1.1 mJ of 4, are
/// touched.
inline constexpr double kDebtBegins = 0.3;
/// How fast the factor changes, 1/s: 4.8 % in 10 ms. Larger: the change is felt as a step; smaller:
/// more is owed before the wrench has faded.
inline constexpr double kPayRate = 4.8;
/// Share of the allowance that must be left for all changes to be slow. Smaller: the wrench falls
/// faster once it has to.
inline constexpr double kSlowReserve = 0.5;
/// The slow factor never falls below this: it could not grow back.
inline constexpr double kLeastShare = 0.02;

/// What is owed at the port in a tick.
struct EnergyDebt {
  double owed = 0.0;       ///< given to the hand beyond the budgets, J
  double allowance = 0.0;  ///< J, >= 0
  bool gives = false;      ///< the wrench would give more
};

/// The slow factor on the wrench, in (0, 1], from that of the tick before, `hold_s` >= 0 ago.
[[nodiscard]] HD_REALTIME double paying_share(const EnergyDebt& debt, double hold_s,
                                              double share) noexcept;

/// The factor at once, on what points along the motion, in [0, 1].
[[nodiscard]] HD_REALTIME double reserve_share(const EnergyDebt& debt) noexcept;

}  // namespace hapticd
