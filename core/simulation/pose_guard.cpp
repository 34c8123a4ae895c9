// Judges pose samples. See pose_guard.h. RT: yes.
#include "core/simulation/pose_guard.h"

#include <algorithm>
#include <cmath>

#include "core/math/rotation.h"

namespace hapticd {
namespace {

bool usable(const PoseSample& sample) noexcept {
  for (const double p : sample.p_WH) {
    if (!(std::abs(p) <= kMaxPosition)) return false;
  }
  double largest = 0.0;
  for (const double q : sample.q_WH) {
    if (!(std::abs(q) <= kMaxQuaternionNorm)) return false;
    largest = std::max(largest, std::abs(q));
  }
  const double norm = largest > 0.0 ? to_quaternion(sample.q_WH).norm() : 0.0;
  return norm >= kMinQuaternionNorm && norm <= kMaxQuaternionNorm;
}

PoseVerdict hold(PoseGuard& guard) noexcept {
  ++guard.bad_total;
  ++guard.bad_in_a_row;
  guard.V_WH = Twist{};
  if (!guard.has_pose || guard.bad_in_a_row > kMaxHeldTicks) guard.fault = true;
  return guard.fault ? PoseVerdict::kFault : PoseVerdict::kHeld;
}

Twist velocity(const Pose& X_before, const Pose& X_after, double dt) noexcept {
  return {(X_after.p - X_before.p) / dt, log_rotation(X_after.q * X_before.q.conjugate()) / dt};
}

}  // namespace

PoseVerdict accept_pose(const PoseSample& sample, PoseGuard& guard, double& dt_s) noexcept {
  dt_s = 0.0;
  if (!usable(sample)) return hold(guard);
  const Pose X_new{renormalised(to_quaternion(sample.q_WH)), to_vector(sample.p_WH)};
  if (guard.has_pose && sample.t_ns > guard.t_ns) {
    const double elapsed = 1e-9 * static_cast<double>(sample.t_ns - guard.t_ns);
    guard.V_WH = velocity(guard.X_WH, X_new, elapsed);
    dt_s = std::min(elapsed, kMaxElapsed);
  }
  guard.X_WH = X_new;
  guard.t_ns = guard.has_pose ? std::max(guard.t_ns, sample.t_ns) : sample.t_ns;
  guard.has_pose = true;
  guard.bad_in_a_row = 0;
  return guard.fault ? PoseVerdict::kFault : PoseVerdict::kGood;
}

}  // namespace hapticd
