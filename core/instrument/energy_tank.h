// Bounds what a vibrating string gives to the hand: the tank holds what the vibration still may
// give, and a force held for a tick can never draw more than is in it. Source: S. Stramigioli,
// "Energy-aware robotics", 2015. SI.
// RT: yes, 5 ns.
#pragma once

#include "core/math/realtime.h"

namespace hapticd {

struct EnergyTank {
  double energy = 0.0;      ///< may still be given, J, >= 0
  double held_force = 0.0;  ///< force of the last tick, along the touch normal on the tool, N
};

/// Books the work of the force held over the last tick, with `moved` (m) the tool's motion along
/// the normal since: given work leaves the tank (never below 0), work of the hand comes back, up to
/// `ceiling` (J). Returns the work given, J.
HD_REALTIME double settle_tank(double moved, double ceiling, EnergyTank& tank) noexcept;

/// How far a tool with `speed` (m/s, either sign) moves in dt (s) at most, m, if its speed changes
/// by no more than max_acceleration (m/s^2): (|v| + a_max dt) dt.
[[nodiscard]] HD_REALTIME double hand_reach(double speed, double max_acceleration,
                                            double dt) noexcept;

/// `force` (N, either sign) shortened so that holding it cannot draw more than the tank holds while
/// the tool moves by no more than `reach` (m) along the normal. Keeps it as held_force.
[[nodiscard]] HD_REALTIME double draw_from_tank(double force, double reach,
                                                EnergyTank& tank) noexcept;

}  // namespace hapticd
