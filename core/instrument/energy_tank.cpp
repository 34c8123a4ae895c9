// Bookkeeping of what a vibration may still give to the hand. RT: yes.
#include "core/instrument/energy_tank.h"

#include <algorithm>
#include <cmath>

namespace hapticd {

void settle_tank(double moved, EnergyTank& tank) noexcept {
  const double given = tank.held_force * moved;
  tank.energy = std::clamp(tank.energy - given, -kVibrationReserve, tank.full);
}

double hand_reach(double speed, double max_acceleration, double dt) noexcept {
  return std::max(0.0, (speed + max_acceleration * dt) * dt);
}

double draw_from_tank(double force, double reach, EnergyTank& tank) noexcept {
  const double size = std::abs(force);
  const double may = tank.energy + kVibrationReserve;
  if (size * reach > may) force *= may / (size * reach);
  tank.held_force = force;
  return force;
}

}  // namespace hapticd
