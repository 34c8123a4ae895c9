// Growth of a force is limited, decrease never: P is the point of the segment [0, F_prev] nearest
// to F, and out = P + (F - P) shortened to the step. So a force that falls, or stops, does so at
// once (a pluck stays crisp), and one that grows, turns round or moves sideways does so no faster
// than the limit. Frames: any one. RT: yes, about 10 ns.
#pragma once

#include "core/math/realtime.h"
#include "core/math/vector.h"

namespace hapticd {

/// `F` as near as one may come to it from `F_prev` with growth of at most `step` >= 0. All finite
/// and below 1e150. `limited` becomes true when the result differs from F.
[[nodiscard]] HD_REALTIME Vector3 slewed(const Vector3& F, const Vector3& F_prev, double step,
                                         bool& limited) noexcept;

}  // namespace hapticd
