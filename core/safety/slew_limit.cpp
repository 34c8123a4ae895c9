// Limited growth, free decrease. See slew_limit.h. RT: yes.
#include "core/safety/slew_limit.h"

#include <algorithm>

namespace hapticd {

Vector3 slewed(const Vector3& F, const Vector3& F_prev, double step, bool& limited) noexcept {
  // The nearest point of [0, F_prev]; a previous force too small to square is none.
  const double square = F_prev.squaredNorm();
  const double share = square > 0.0 ? std::clamp(F.dot(F_prev) / square, 0.0, 1.0) : 0.0;
  const Vector3 P = share * F_prev;
  const Vector3 growth = F - P;
  const double size = growth.norm();
  if (size <= step) return F;
  limited = true;
  return P + growth * (step / size);
}

}  // namespace hapticd
