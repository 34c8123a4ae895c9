// See wave_tank.h. RT: yes.
#include "core/instrument/wave_tank.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/// What the static laws are held to have stored without having got it, at most, J: more than single
/// ticks err by. What is forgotten beyond it a hand that rubs the string would win, time and again.
constexpr double kMostOwed = 1e-3;
/// What a string lends a hand that may turn to it, J, as far as it rings with more than kLentFrom:
/// a hand that comes fast is foretold to draw far more than it does, and would feel little of a
/// faint ringing.
constexpr double kMostLent = 15e-6;
constexpr double kLentFrom = 10e-6;

double dot(const Transverse& a, const Transverse& b) noexcept { return a.y * b.y + a.z * b.z; }

/// What the static laws of all tools let go of beyond what they have given the hands, J: while they
/// hold, their work is what they store, and how a held force errs in that is for the device's loop
/// to watch. By the trapezoid: what it errs by goes to and fro with the hand, and adds up to
/// nothing. Negative where they store more than the hands have put in.
double let_go(const WaveTank& tank, std::span<const WavePort> ports) noexcept {
  double lost = 0.0;
  double given = 0.0;
  for (const WavePort& port : ports) {
    const std::size_t k = port.tool;
    lost += tank.stored[k] - port.stored;
    given += 0.5 * (dot(tank.law[k], port.moved) + tank.pull[k] * port.slid);
    given += 0.5 * (dot(port.law, port.moved) + port.pull * port.slid);
  }
  return lost - given;
}

}  // namespace

void settle_wave_tank(std::span<const WavePort> ports, double spare, WaveTank& tank) noexcept {
  // What single ticks err by goes to and fro: only what is left of it counts.
  tank.let_go = std::max(tank.let_go + let_go(tank, ports), -kMostOwed);
  if (tank.let_go > 0.0) {
    tank.energy += tank.let_go;
    tank.let_go = 0.0;
  }
  for (const WavePort& port : ports) {
    const std::size_t k = port.tool;
    tank.energy -= dot(tank.beyond[k], port.moved);
    tank.law[k] = port.law;
    tank.pull[k] = port.pull;
    tank.stored[k] = port.stored;
  }
  const double most = std::max(0.0, spare) + kTankReserve;
  tank.energy = std::clamp(tank.energy, -most - kMostLent, most);
}

void draw_wave_forces(std::span<const WavePort> ports, double ringing, std::span<Transverse> beyond,
                      WaveTank& tank) noexcept {
  double draw = 0.0;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    beyond[i] = {ports[i].felt.y - ports[i].law.y, ports[i].felt.z - ports[i].law.z};
    const double furthest = std::sqrt(dot(beyond[i], beyond[i])) * ports[i].aside;
    draw += std::max(0.0, dot(beyond[i], ports[i].way) + furthest);
  }
  const double lent = std::clamp(ringing - kLentFrom, 0.0, kMostLent);
  const double room = std::max(0.0, tank.energy + lent);
  const double share = draw > room ? room / draw : 1.0;
  tank.beyond = {};
  for (std::size_t i = 0; i < ports.size(); ++i) {
    beyond[i] = {share * beyond[i].y, share * beyond[i].z};
    tank.beyond[ports[i].tool] = beyond[i];
  }
}

}  // namespace hapticd
