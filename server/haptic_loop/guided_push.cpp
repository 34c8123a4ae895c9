// See guided_push.h. RT: yes.
#include "server/haptic_loop/guided_push.h"

#include <algorithm>

namespace hapticd {
namespace {

/// Unit vector of `axis`.
Vector3 direction(PushAxis axis) noexcept {
  Vector3 e = Vector3::Zero();
  e[(axis - 1) / 2] = axis % 2 == 1 ? 1.0 : -1.0;
  return e;
}

/// From 0 at the edge of a ramp to 1 at its top.
double ramp(double since_edge_s) noexcept {
  return std::clamp(since_edge_s / kPushRamp_s, 0.0, 1.0);
}

}  // namespace

bool follow_push(PushAxis asked, LoopState state, double dt_s, GuidedPush& push) noexcept {
  if (state == LoopState::kReleasing) return false;
  if (state != LoopState::kEngaged) {
    push = {};
    return false;
  }
  if (asked != 0) {
    push = {asked, 0.0};
    return true;
  }
  if (push.axis == 0) return false;
  const bool pushed = push.t_s < kPush_s;
  // A pause must not become a jump.
  push.t_s += std::min(dt_s, kMaxRampStep_s);
  const bool over = pushed && !(push.t_s < kPush_s);
  if (!(push.t_s < kPush_s + kPushRamp_s)) push = {};
  return over;
}

Wrench with_push(const GuidedPush& push, const Wrench& rendered) noexcept {
  if (push.axis == 0) return rendered;
  const double share = ramp(push.t_s - kPush_s);
  const double size = kPushForce * ramp(std::min(push.t_s, kPush_s - push.t_s));
  return {rendered.f * share + direction(push.axis) * size, rendered.t * share};
}

}  // namespace hapticd
