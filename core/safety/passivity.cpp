// Energy at the port. See passivity.h. RT: yes.
#include "core/safety/passivity.h"

#include <algorithm>

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

void PassivityControl::observe(const Wrench& F_prev, const Twist& displacement,
                               double dt_s) noexcept {
  double given = port_.given + power(F_prev, displacement);
  if (given > 0.0 && dt_s > 0.0) {
    // The damping took b times the integral of v^2, which is at least b dx^2 / dt.
    const double repaid = limits_.damping * displacement.v.squaredNorm() +
                          limits_.rotational_damping * displacement.w.squaredNorm();
    given = std::max(0.0, given - repaid / dt_s);
  }
  // Above the bound come motions no hand makes, and what a string gave out of its tank: forgotten.
  port_.given = std::clamp(given, -limits_.credit, limits_.allowance + budget_);
}

Wrench PassivityControl::faded(const Wrench& F, const Twist& V, double hold_s) noexcept {
  const double gives = F.f.dot(V.v) + F.t.dot(V.w);
  const EnergyDebt debt{port_.given - budget_, limits_.allowance, gives > 0.0};
  port_.share = paying_share(debt, hold_s, port_.share);
  if (port_.share >= 1.0) return F;
  port_.removed += (1.0 - port_.share) * std::max(0.0, gives) * hold_s;
  return {F.f * port_.share, F.t * port_.share};
}

Wrench PassivityControl::damped(const Wrench& F, const Twist& V, double hold_s) noexcept {
  const double along = F.f.dot(V.v) * hold_s;
  const double about = F.t.dot(V.w) * hold_s;
  const double excess =
      port_.given + along + about - (limits_.soft_share * limits_.allowance + budget_);
  const double gives = std::max(0.0, along) + std::max(0.0, about);
  if (!(gives > 0.0)) return F;
  const double at_once = 1.0 - reserve_share({port_.given - budget_, limits_.allowance, true});
  const double share = std::min(1.0, std::max(at_once, excess / gives));
  if (!(share > 0.0)) return F;
  port_.removed += share * gives;
  return {along > 0.0 ? without(F.f, V.v, share) : F.f,
          about > 0.0 ? without(F.t, V.w, share) : F.t};
}

double PassivityControl::energy_share(const Wrench& F, const Twist& V,
                                      double hold_s) const noexcept {
  const double left = limits_.allowance + budget_ - port_.given;
  const double jerk = limits_.acceleration * hold_s * hold_s;
  const double twist = limits_.angular_acceleration * hold_s * hold_s;
  const double worst = std::max(0.0, F.f.dot(V.v)) * hold_s + F.f.norm() * jerk +
                       std::max(0.0, F.t.dot(V.w)) * hold_s + F.t.norm() * twist;
  if (worst <= left) return 1.0;
  return std::max(0.0, left) / worst;
}

}  // namespace hapticd
