// Energy at the port. See passivity.h. RT: yes.
#include "core/safety/passivity.h"

#include <algorithm>
#include <numeric>

#include "core/safety/energy_debt.h"

namespace hapticd {
namespace {

/// Speeds whose square is below this have no direction, (m/s)^2 and (rad/s)^2.
constexpr double kStill = 1e-30;

/// `F` less `share` of its part along `V`.
Vector3 without(const Vector3& F, const Vector3& V, double share) noexcept {
  const double square = V.squaredNorm();
  return square > kStill ? Vector3(F - V * (share * F.dot(V) / square)) : F;
}

}  // namespace

double PassivityControl::counted(double given, const Wrench& F, const Twist& displacement,
                                 double dt_s) const noexcept {
  given += power(F, displacement);
  if (given > 0.0 && dt_s > 0.0) {
    // The damping took b times the integral of v^2, which is at least b dx^2 / dt.
    const double repaid = limits_.damping * displacement.v.squaredNorm() +
                          limits_.rotational_damping * displacement.w.squaredNorm();
    given = std::max(0.0, given - repaid / dt_s - kForgivenPower * dt_s);
  }
  // Above the bound come motions no hand makes, and what a string gave out of its tank: forgotten.
  return std::clamp(given, -limits_.credit, limits_.allowance + budget_);
}

void PassivityControl::observe(const Wrench& F_prev, const Twist& displacement,
                               double dt_s) noexcept {
  port_.given = counted(port_.given, F_prev, displacement, dt_s);
  if (flight_ == 0) return;
  WrenchFlight& flight = port_.flight;
  for (std::size_t k = 0; k < static_cast<std::size_t>(flight_); ++k) {
    const Wrench felt{to_vector(flight.f_H_D[k]), to_vector(flight.t_H_D[k])};
    flight.given[k] = counted(flight.given[k], felt, displacement, dt_s);
  }
  std::copy_backward(flight.f_H_D.begin(), flight.f_H_D.end() - 1, flight.f_H_D.end());
  std::copy_backward(flight.t_H_D.begin(), flight.t_H_D.end() - 1, flight.t_H_D.end());
  flight.f_H_D[0] = to_array(F_prev.f);
  flight.t_H_D[0] = to_array(F_prev.t);
}

double PassivityControl::owed() const noexcept {
  const auto begin = port_.flight.given.begin();
  return std::accumulate(begin, begin + flight_, port_.given,
                         [](double a, double b) { return std::max(a, b); });
}

double PassivityControl::worst(const Wrench& F, const Twist& V, double hold_s,
                               int ticks) const noexcept {
  const double gained_s2 = hold_s * hold_s * (1 + ticks);
  return std::max(0.0, F.f.dot(V.v)) * hold_s + F.f.norm() * (limits_.acceleration * gained_s2) +
         std::max(0.0, F.t.dot(V.w)) * hold_s +
         F.t.norm() * (limits_.angular_acceleration * gained_s2);
}

double PassivityControl::under_way(const Twist& V, double hold_s, int delay) const noexcept {
  double sum = 0.0;
  for (int ticks = 0; ticks < delay; ++ticks) {
    // The oldest comes first.
    const auto k = static_cast<std::size_t>(delay - 1 - ticks);
    sum += worst({to_vector(port_.flight.f_H_D[k]), to_vector(port_.flight.t_H_D[k])}, V, hold_s,
                 ticks);
  }
  return sum;
}

void PassivityControl::rest() noexcept {
  port_.given = std::max(0.0, port_.given);
  port_.removed = 0.0;
  port_.share = 1.0;
  for (double& given : port_.flight.given) given = std::max(0.0, given);
}

Wrench PassivityControl::faded(const Wrench& F, const Twist& V, double hold_s) noexcept {
  const double gives = F.f.dot(V.v) + F.t.dot(V.w);
  const EnergyDebt debt{owed() - budget_, limits_.allowance, gives > 0.0};
  port_.share = paying_share(debt, hold_s, port_.share);
  if (port_.share >= 1.0) return F;
  port_.removed += (1.0 - port_.share) * std::max(0.0, gives) * hold_s;
  return {F.f * port_.share, F.t * port_.share};
}

Wrench PassivityControl::damped(const Wrench& F, const Twist& V, double hold_s) noexcept {
  const double along = F.f.dot(V.v) * hold_s;
  const double about = F.t.dot(V.w) * hold_s;
  const double excess = owed() + along + about - (limits_.soft_share * limits_.allowance + budget_);
  const double gives = std::max(0.0, along) + std::max(0.0, about);
  if (!(gives > 0.0)) return F;
  const double at_once = 1.0 - reserve_share({owed() - budget_, limits_.allowance, true});
  const double share = std::min(1.0, std::max(at_once, excess / gives));
  if (!(share > 0.0)) return F;
  port_.removed += share * gives;
  return {along > 0.0 ? without(F.f, V.v, share) : F.f,
          about > 0.0 ? without(F.t, V.w, share) : F.t};
}

double PassivityControl::energy_share(const Wrench& F, const Twist& V,
                                      double hold_s) const noexcept {
  double share = 1.0;
  for (int delay = 0; delay <= flight_; ++delay) {
    const double given =
        delay == 0 ? port_.given : port_.flight.given[static_cast<std::size_t>(delay - 1)];
    const double left =
        std::max(0.0, limits_.allowance + budget_ - given - under_way(V, hold_s, delay));
    const double most = worst(F, V, hold_s, delay);
    if (most > left) share = std::min(share, left / most);
  }
  return share;
}

}  // namespace hapticd
