// The factors that fade. See energy_debt.h. RT: yes.
#include "core/safety/energy_debt.h"

#include <algorithm>

namespace hapticd {
namespace {

/// A longer tick changes the factor no more than this one, s.
constexpr double kLongest_s = 5e-3;

}  // namespace

double paying_share(const EnergyDebt& debt, double hold_s, double share) noexcept {
  const double change = kPayRate * std::min(hold_s, kLongest_s);
  const bool pays = debt.gives && debt.owed > kDebtBegins * debt.allowance;
  if (pays) return std::max(kLeastShare, share * (1.0 - change));
  return std::min(1.0, share * (1.0 + change));
}

double reserve_share(const EnergyDebt& debt) noexcept {
  const double slow = kSlowReserve * debt.allowance;
  const double left = debt.allowance - debt.owed;
  return left < slow ? std::max(0.0, left) / slow : 1.0;
}

}  // namespace hapticd
