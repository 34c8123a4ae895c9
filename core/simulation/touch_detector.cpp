// See touch_detector.h. RT: yes.
#include "core/simulation/touch_detector.h"

#include <algorithm>

#include "core/contact/coupling_axes.h"

namespace hapticd {
namespace {

/// Of this tick, a pair of part and object.
struct TouchedPair {
  std::int32_t contact;  ///< the deepest of the report
  double force;          ///< sum, N
  bool before;           ///< has been a touch
};

using TouchedPairs = FixedVector<TouchedPair, kMaxTouches>;

TouchedPair* find(const ContactReport& report, TouchedPairs& pairs, std::int32_t part,
                  ObstacleKind kind, std::int32_t obstacle) noexcept {
  for (TouchedPair& pair : pairs) {
    const ContactTick& contact = report.contacts[static_cast<std::size_t>(pair.contact)];
    if (contact.part == part && contact.key.kind == kind && contact.key.obstacle == obstacle) {
      return &pair;
    }
  }
  return nullptr;
}

/// The touch of a pair as it is now.
TouchEvent touch_of(const ContactReport& report, const TouchedPair& pair,
                    const TouchTick& tick) noexcept {
  const ContactTick& contact = report.contacts[static_cast<std::size_t>(pair.contact)];
  const Vector3 nhat = to_vector(contact.nhat_OG_W);
  const Vector3 v = point_velocity(tick.V_WH, to_vector(contact.p_WC) - tick.p_WG);
  TouchEvent touch;
  touch.begins = true;
  touch.part = contact.part;
  touch.kind = contact.key.kind;
  touch.obstacle = contact.key.obstacle;
  touch.lambda = contact.lambda;
  touch.p_WC = contact.p_WC;
  touch.nhat_OG_W = contact.nhat_OG_W;
  touch.normal_speed = -v.dot(nhat);
  touch.tangential_speed = (v + touch.normal_speed * nhat).norm();
  touch.force = pair.force;
  return touch;
}

void gather(const ContactReport& report, const TouchTick& tick, TouchedPairs& now) noexcept {
  for (std::size_t k = 0; k < report.contacts.size(); ++k) {
    const ContactTick& contact = report.contacts[k];
    const ContactKey& key = contact.key;
    if (is_string(key) && key.obstacle < tick.strings) continue;
    TouchedPair* pair = find(report, now, contact.part, key.kind, key.obstacle);
    if (pair == nullptr) {
      if (!now.push_back({static_cast<std::int32_t>(k), 0.0, false})) continue;
      pair = now.end() - 1;
    }
    pair->force += contact.force;
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
  TouchedPairs now;
  gather(report, tick, now);
  auto& touches = detector.touches;
  std::size_t kept = 0;
  for (TouchEvent& touch : touches) {
    TouchedPair* pair = find(report, now, touch.part, touch.kind, touch.obstacle);
    if (pair == nullptr) {
      touch.t_ns = tick.t_ns;
      touch.begins = false;
      events.push_back(touch);
      continue;
    }
    const double most = touch.force;
    TouchEvent& still = touches[kept++];
    still = touch_of(report, *pair, tick);
    still.force = std::max(still.force, most);
    pair->before = true;
  }
  touches.truncate(kept);
  for (const TouchedPair& pair : now) {
    if (pair.before || !(pair.force > 0.0)) continue;
    TouchEvent touch = touch_of(report, pair, tick);
    const double depth = depth_under(tick.stiffness, touch.force, to_vector(touch.nhat_OG_W));
    touch.t_ns = instant(tick, depth, touch.normal_speed);
    if (touches.push_back(touch)) events.push_back(touch);
  }
}

}  // namespace hapticd
