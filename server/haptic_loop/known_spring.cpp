// See known_spring.h. RT: yes.
#include "server/haptic_loop/known_spring.h"

#include <algorithm>
#include <cmath>

#include "core/safety/loop_state.h"
#include "server/haptic_loop/guided_push.h"

namespace hapticd {
namespace {

/// Ring that is under way, [0, kRings]; kRings: all are over.
int ring_of(double t_s) noexcept { return std::min(static_cast<int>(t_s / kRing_s), kRings); }

/// Share of the pull, with its side: it grows, lasts, and is gone at once.
double pull_of(double t_s) noexcept {
  const int ring = ring_of(t_s);
  const double since_s = t_s - ring * kRing_s;
  if (since_s >= kPullRamp_s + kPullHold_s) return 0.0;
  const double side = ring < kRings / 2 ? 1.0 : -1.0;
  return side * std::min(since_s / kPullRamp_s, 1.0);
}

}  // namespace

void follow_measuring(const SpringTick& tick, KnownSpring& spring, PortEnergy& port) noexcept {
  if (tick.state == LoopState::kReleasing) return;
  if (tick.state != LoopState::kEngaged) {
    if (spring.axis != 0) port.given = std::max(port.given, spring.owed);
    spring = {};
    return;
  }
  if (tick.asked != 0) {
    const double owed = spring.axis != 0 ? spring.owed : std::max(port.given, 0.0);
    spring = {tick.asked, 0.0, to_array(tick.p_DH), owed};
    port = {};
    return;
  }
  if (spring.axis == 0) return;
  const int ring = ring_of(spring.t_s);
  // A pause must not become a jump.
  spring.t_s += std::min(tick.dt_s, kMaxRampStep_s);
  const bool far = (tick.p_DH - to_vector(spring.anchor)).norm() > kMaxExcursion;
  if (far || tick.clutch_open) spring.t_s = std::max(spring.t_s, kMeasuring_s);
  if (ring_of(spring.t_s) != ring) {
    port = {};
    if (ring_of(spring.t_s) == kRings) port.given = spring.owed;
  }
  if (!(spring.t_s < kMeasuring_s + kPushRamp_s)) spring = {};
}

Wrench with_spring(const KnownSpring& spring, const SpringStrength& strength, const Vector3& p_DH,
                   const Wrench& rendered) noexcept {
  // Numbers that are lost are for the safety stage to see.
  const bool lost = !rendered.f.allFinite() || !rendered.t.allFinite();
  if (spring.axis == 0 || lost) return rendered;
  const int ring = ring_of(spring.t_s);
  if (ring == kRings) {
    const double share = std::clamp((spring.t_s - kMeasuring_s) / kPushRamp_s, 0.0, 1.0);
    return {rendered.f * share, rendered.t * share};
  }
  const double stiffness = strength.stiffness * (ring % 2 == 0 ? 1.0 : kSoftRing);
  Vector3 f = (to_vector(spring.anchor) - p_DH) * stiffness;
  const double pull =
      std::min({strength.pull, stiffness * kMaxPull, std::sqrt(2.0 * stiffness * strength.energy)});
  f[place_of(spring.axis)] += pull_of(spring.t_s) * pull;
  return {f, Vector3::Zero()};
}

}  // namespace hapticd
