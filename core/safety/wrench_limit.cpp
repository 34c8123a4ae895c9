// Limits along the direction. See wrench_limit.h. RT: yes.
#include "core/safety/wrench_limit.h"

#include <algorithm>

namespace hapticd {
namespace {

Vector3 shortened(const Vector3& v, double limit) noexcept {
  // Dividing by the largest component first keeps the square of 1e200 from overflowing.
  const double largest = v.cwiseAbs().maxCoeff();
  if (!(largest > 0.0)) return v;
  const Vector3 direction = v / largest;
  const double length = direction.norm();
  // What is within the limit keeps its bits.
  if (largest * length <= limit) return v;
  return direction * (limit / length);
}

}  // namespace

Wrench limited(const Wrench& F, const WrenchLimits& limits) noexcept {
  if (!F.f.allFinite() || !F.t.allFinite()) return {};
  return {shortened(F.f, limits.force), shortened(F.t, limits.torque)};
}

}  // namespace hapticd
