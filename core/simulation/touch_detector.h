// Begin and end of touches between a part of the tool and a body or rigid line, with hysteresis: a
// touch begins with force and ends when the part is further than twice the skin. Strings have
// their own detector (core/instrument). Frames: W. SI. RT: yes, about 20 ns per contact.
#pragma once

#include "core/collision/obstacles.h"
#include "core/contact/virtual_coupling.h"
#include "core/math/realtime.h"
#include "core/math/wrench.h"
#include "core/simulation/contact_report.h"

namespace hapticd {

/// Pairs of part and object that touch at once, at most; further ones go unreported.
inline constexpr std::size_t kMaxTouches = 64;

/// A touch of a body or rigid line began or ended.
struct TouchEvent {
  std::int64_t t_ns = 0;  ///< the instant, inside the tick
  bool begins = false;
  std::int32_t part = 0;  ///< of the tool
  ObstacleKind kind = ObstacleKind::kBody;
  std::int32_t obstacle = 0;      ///< index among the capsules, or among the bodies
  double lambda = 0.0;            ///< along a capsule
  Array3 p_WC{};                  ///< m
  Array3 nhat_OG_W{};             ///< unit
  double normal_speed = 0.0;      ///< of the hand against the object along -nhat, m/s
  double tangential_speed = 0.0;  ///< m/s
  double force = 0.0;             ///< of this tick; at the end the largest of the touch, N
};

/// Events of one tick.
using TouchEvents = FixedVector<TouchEvent, 2 * kMaxTouches>;

/// What the detector keeps from tick to tick: each touch as it was last, with the largest force.
struct TouchDetector {
  FixedVector<TouchEvent, kMaxTouches> touches;
};

/// What of a tick the detector needs.
struct TouchTick {
  std::int64_t t_ns = 0;
  std::int64_t dt_ns = 0;       ///< since the tick before
  Vector3 p_WG;                 ///< point V_WH is the velocity of, m
  Twist V_WH;                   ///< of the hand
  CouplingStiffness stiffness;  ///< of the coupling: how deep the hand is
  std::int32_t strings = 0;     ///< capsules below this number are strings: not looked at
};

/// Compares the contacts of a tick with the touches so far and appends what began and ended. The
/// instant of a beginning is when the hand, at its present speed, passed the surface, within the
/// tick; that of an end is the end of the tick.
HD_REALTIME void detect_touches(const ContactReport& report, const TouchTick& tick,
                                TouchDetector& detector, TouchEvents& events) noexcept;

}  // namespace hapticd
