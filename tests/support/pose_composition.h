// The product of two poses, for truths and moved worlds.
#pragma once

#include "core/math/pose.h"

namespace hapticd {

/// X_AC = X_AB X_BC; not renormalised.
[[nodiscard]] inline Pose compose(const Pose& X_AB, const Pose& X_BC) noexcept {
  return {X_AB.q * X_BC.q, transform(X_AB, X_BC.p)};
}

}  // namespace hapticd
