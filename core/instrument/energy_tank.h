// Bounds what a vibrating string gives to the hand: the tank holds what the vibration still may
// give, and a force held for a tick can never draw more than that and a reserve. Source: S.
// Stramigioli, "Energy-aware robotics", 2015. SI. RT: yes, 5 ns.
#pragma once

#include "core/math/realtime.h"

namespace hapticd {

/// What a vibration may give beyond its energy, J: so that the hardest pull that a hand could make
/// within a tick does not shorten the force of a string that rings softly.
inline constexpr double kVibrationReserve = 50e-6;

struct EnergyTank {
  double full = 0.0;        ///< most that is in it, J, >= 0
  double energy = 0.0;      ///< may still be given, J, in [-kVibrationReserve, full]
  double held_force = 0.0;  ///< force of the last tick, along the touch normal on the tool, N
};

/// Books the work of the force held over the last tick, with `moved` (m) the tool's motion along
/// the normal since: given work leaves the tank (never below -kVibrationReserve), work of the hand
/// comes back, until it is full.
HD_REALTIME void settle_tank(double moved, EnergyTank& tank) noexcept;

/// How far along a force a tool that has `speed` (m/s, either sign) along it moves in dt (s) at
/// most, m, if its speed changes by no more than max_acceleration (m/s^2): (v + a_max dt) dt, >= 0.
[[nodiscard]] HD_REALTIME double hand_reach(double speed, double max_acceleration,
                                            double dt) noexcept;

/// `force` (N, either sign) shortened so that holding it cannot draw more than the tank and the
/// reserve hold while the tool moves by no more than `reach` (m) along it. Keeps it as held_force.
[[nodiscard]] HD_REALTIME double draw_from_tank(double force, double reach,
                                                EnergyTank& tank) noexcept;

}  // namespace hapticd
