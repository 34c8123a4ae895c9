// Bookkeeping of what a vibration may still give to the hand. RT: yes.
#include "core/instrument/energy_tank.h"

#include <algorithm>
#include <cmath>

namespace hapticd {

double settle_tank(double moved, double ceiling, EnergyTank& tank) noexcept {
  const double given = tank.held_force * moved;
  // What is above the ceiling already stays: the ceiling bounds what comes back.
  const double most = std::max(ceiling, tank.energy);
  tank.energy = std::clamp(tank.energy - given, 0.0, most);
  return given;
}

double hand_reach(double speed, double max_acceleration, double dt) noexcept {
  return (std::abs(speed) + max_acceleration * dt) * dt;
}

double draw_from_tank(double force, double reach, EnergyTank& tank) noexcept {
  const double size = std::abs(force);
  if (size * reach > tank.energy) force *= tank.energy / (size * reach);
  tank.held_force = force;
  return force;
}

}  // namespace hapticd
