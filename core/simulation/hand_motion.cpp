// See hand_motion.h. RT: yes.
#include "core/simulation/hand_motion.h"

#include <algorithm>
#include <cmath>

#include "core/math/assert.h"
#include "core/math/rotation.h"

namespace hapticd {

double follow(const HandPose& hand, HandMotion& motion) noexcept {
  // The placed pose is normalised once more: it is what forces have always been computed from.
  const Pose X_WH{renormalised(to_quaternion(hand.q_WH)), to_vector(hand.p_WH)};
  HD_ASSERT(X_WH.p.allFinite() && X_WH.q.coeffs().allFinite());
  double dt_s = 0.0;
  if (motion.has_pose && hand.t_ns > motion.t_ns) {
    const double elapsed_s = 1e-9 * static_cast<double>(hand.t_ns - motion.t_ns);
    const Pose& before = motion.X_WH;
    motion.V_WH = {(X_WH.p - before.p) / elapsed_s,
                   log_rotation(X_WH.q * before.q.conjugate()) / elapsed_s};
    dt_s = std::min(elapsed_s, kMaxElapsed);
  }
  motion.X_WH = X_WH;
  motion.t_ns = motion.has_pose ? std::max(motion.t_ns, hand.t_ns) : hand.t_ns;
  motion.has_pose = true;
  return dt_s;
}

}  // namespace hapticd
