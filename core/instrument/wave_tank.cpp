// See wave_tank.h. RT: yes.
#include "core/instrument/wave_tank.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

double dot(const Transverse& a, const Transverse& b) noexcept { return a.y * b.y + a.z * b.z; }

/// What the static law lets go of beyond what it may have given the hand, J: while it holds, its
/// work is what it stores, and how a held force errs in that is for the device's loop to watch.
double let_go(const WaveTank& tank, const WavePort& port) noexcept {
  const double given =
      std::max({0.0, dot(tank.law[port.tool], port.moved), dot(port.law, port.moved)});
  return std::max(0.0, tank.stored[port.tool] - port.stored - given);
}

}  // namespace

void settle_wave_tank(std::span<const WavePort> ports, double spare, WaveTank& tank) noexcept {
  for (const WavePort& port : ports) {
    const std::size_t k = port.tool;
    tank.energy -= dot(tank.beyond[k], port.moved);
    tank.energy += let_go(tank, port);
    tank.law[k] = port.law;
    tank.stored[k] = port.stored;
  }
  const double most = std::max(0.0, spare) + kTankReserve;
  tank.energy = std::clamp(tank.energy, -most, most);
}

void draw_wave_forces(std::span<const WavePort> ports, std::span<Transverse> beyond,
                      WaveTank& tank) noexcept {
  double draw = 0.0;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    beyond[i] = {ports[i].felt.y - ports[i].law.y, ports[i].felt.z - ports[i].law.z};
    const double furthest = std::sqrt(dot(beyond[i], beyond[i])) * ports[i].aside;
    draw += std::max(0.0, dot(beyond[i], ports[i].way) + furthest);
  }
  const double room = std::max(0.0, tank.energy);
  const double share = draw > room ? room / draw : 1.0;
  tank.beyond = {};
  for (std::size_t i = 0; i < ports.size(); ++i) {
    beyond[i] = {share * beyond[i].y, share * beyond[i].z};
    tank.beyond[ports[i].tool] = beyond[i];
  }
}

}  // namespace hapticd
