// See touch_detector.h. RT: yes.
#include "core/simulation/touch_detector.h"

#include <algorithm>

namespace hapticd {
namespace {

using Touches = FixedVector<TouchEvent, kMaxTouches>;

TouchEvent* find(Touches& touches, std::int32_t part, ObstacleKind kind,
                 std::int32_t obstacle) noexcept {
  for (TouchEvent& touch : touches) {
    if (touch.part == part && touch.kind == kind && touch.obstacle == obstacle) return &touch;
  }
  return nullptr;
}

/// The touch whose deepest contact this is, its force still to be summed.
TouchEvent touch_of(const ContactTick& contact, const TouchTick& tick) noexcept {
  const Vector3 nhat = to_vector(contact.nhat_OG_W);
  const Vector3 v = point_velocity(tick.V_WH, to_vector(contact.p_WC) - tick.p_WG);
  TouchEvent touch;
  touch.part = contact.part;
  touch.kind = contact.key.kind;
  touch.obstacle = contact.key.obstacle;
  touch.lambda = contact.lambda;
  touch.p_WC = contact.p_WC;
  touch.nhat_OG_W = contact.nhat_OG_W;
  touch.normal_speed = -v.dot(nhat);
  touch.tangential_speed = (v + touch.normal_speed * nhat).norm();
  return touch;
}

/// The pairs of this tick, with the sum of their forces.
void gather(const ContactReport& report, const TouchTick& tick, Touches& now) noexcept {
  for (const ContactTick& contact : report.contacts) {
    const ContactKey& key = contact.key;
    if (is_string(key) && key.obstacle < tick.strings) continue;
    TouchEvent* touch = find(now, contact.part, key.kind, key.obstacle);
    if (touch == nullptr) {
      if (!now.push_back(touch_of(contact, tick))) continue;
      touch = now.end() - 1;
    }
    touch->force += contact.force;
  }
}

/// The hand has gone `way` (m) since the instant, at `speed` (m/s).
std::int64_t instant(const TouchTick& tick, double way, double speed) noexcept {
  const auto dt = static_cast<double>(tick.dt_ns);
  const double ago = speed > 0.0 ? std::clamp(1e9 * way / speed, 0.0, dt) : 0.0;
  return tick.t_ns - static_cast<std::int64_t>(ago);
}

}  // namespace

void detect_touches(const ContactReport& report, const TouchTick& tick, TouchDetector& detector,
                    TouchEvents& events) noexcept {
  Touches now;
  gather(report, tick, now);
  Touches kept;
  for (TouchEvent& before : detector.touches) {
    TouchEvent* touch = find(now, before.part, before.kind, before.obstacle);
    if (touch == nullptr) {
      before.t_ns = tick.t_ns;
      before.begins = false;
      events.push_back(before);
      continue;
    }
    touch->force = std::max(touch->force, before.force);
    touch->begins = true;
    kept.push_back(*touch);
  }
  for (TouchEvent& touch : now) {
    if (touch.begins || !(touch.force > 0.0)) continue;
    touch.begins = true;
    touch.t_ns = instant(tick, touch.force / tick.kt, touch.normal_speed);
    if (kept.push_back(touch)) events.push_back(touch);
  }
  detector.touches = kept;
}

}  // namespace hapticd
