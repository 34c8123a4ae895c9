// See printed_string.h.
#include "tests/oracle/printed_string.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

constexpr double kPi = 3.14159265358979323846;
/// As the loop's own tank has it (MODEL.md 4): more than a held device can do, m/s^2.
constexpr double kMaxAcceleration = 500.0;

/// Printed as sin(delta / L): of the end itself the sine of one radian.
double printed_sine(double delta, double length) {
  return length > 0.0 ? std::sin(delta / length) : 0.0;
}

}  // namespace

PrintedDeflection printed_deflection(const StringConstants& string, double lambda, double delta) {
  PrintedDeflection d;
  const double a = lambda * string.length;
  const double b = (1.0 - lambda) * string.length;
  d.L1 = std::sqrt(a * a + delta * delta);
  d.L2 = std::sqrt(b * b + delta * delta);
  d.theta_1 = std::atan2(delta, a);
  d.theta_2 = std::atan2(delta, b);
  if (!(string.length > 0.0)) return d;
  d.F_i = string.axial_stiffness * (d.L1 + d.L2 - string.length) / string.length;
  d.force = (string.tension + d.F_i) * (printed_sine(delta, d.L1) + printed_sine(delta, d.L2));
  return d;
}

void PrintedVibration::advance(const StringConstants& string, double delta, double lambda,
                               double dt_s) {
  since_s_ += dt_s;
  const bool touches = delta >= 0.0;
  if (touches) {
    delta_max_ = std::max(delta_max_, delta);
    lambda_ = std::clamp(lambda, 0.0, 1.0);
  } else if (touched_) {
    // Released: the maximum of delta becomes the maximum radius.
    r_max_ = delta_max_;
    since_s_ = 0.0;
    const double share = lambda_ * (1.0 - lambda_);
    const bool bends = string.length > 0.0 && share > 0.0;
    k_v_ = bends ? string.tension / (string.length * share) : 0.0;
    tank_ = EnergyTank{energy(string), energy(string), 0.0};
    delta_max_ = 0.0;
  }
  touched_ = touches;
  tank_.full = energy(string);
  tank_.energy = std::min(tank_.energy, tank_.full);
  if (!touches) tank_.held_force = 0.0;
}

double PrintedVibration::radius(const StringConstants& string) const {
  return string.decay > 0.0 ? r_max_ * std::exp(-since_s_ / string.decay) : 0.0;
}

double PrintedVibration::energy(const StringConstants& string) const {
  const double r = radius(string);
  return string.length > 0.0 ? kPi * kPi * string.tension * r * r / (4.0 * string.length) : 0.0;
}

double PrintedVibration::force(const StringConstants& string,
                               const PrintedVibrationOptions& options, double moved, double dt_s) {
  const double omega = 2.0 * kPi * string.frequency;
  const double wanted = k_v_ * radius(string) * std::sin(omega * since_s_);
  if (!options.tank || !(dt_s > 0.0)) return wanted;
  settle_tank(moved, tank_);
  const double along = (wanted < 0.0 ? -moved : moved) / dt_s;
  return draw_from_tank(wanted, hand_reach(along, kMaxAcceleration, dt_s), tank_);
}

}  // namespace hapticd
