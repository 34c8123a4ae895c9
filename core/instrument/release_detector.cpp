// Touch, arming, loss and release of one string. RT: yes.
#include "core/instrument/release_detector.h"

#include <algorithm>
#include <cmath>

#include "core/instrument/mode_series.h"

namespace hapticd {
namespace {

constexpr double kNanosecondsPerSecond = 1e9;

/// Where in the tick the distance crosses `boundary`, in [0, 1]; 0 where it does not.
double crossing(const StringTouch& touch, double boundary) noexcept {
  if ((touch.distance_before < boundary) == (touch.distance < boundary)) return 0.0;
  if (boundary == 0.0 && touch.passing >= 0.0) return std::min(touch.passing, 1.0);
  const double travelled = touch.distance - touch.distance_before;
  return std::clamp((boundary - touch.distance_before) / travelled, 0.0, 1.0);
}

std::int64_t instant(const TickTime& time, double fraction) noexcept {
  const auto dt = static_cast<double>(time.dt_ns);
  return time.t_ns - time.dt_ns + static_cast<std::int64_t>(nearest_integer(fraction * dt));
}

/// Part of the tick in which the tool presses the string, in [0, 1], and what its deflection does
/// there, m.
struct Course {
  double from;
  double to;
  double change;
};

/// Whether the contact that ends in this tick ends faster than the hand can have moved away. A hand
/// that is known to have passed the surface has moved that far.
bool slips(const TouchLimits& limits, const StringTouch& touch, double dt,
           const ReleaseDetector& detector) noexcept {
  if (touch.passing >= 0.0) return false;
  const double moved = touch.distance - touch.distance_before;
  const double speed = std::max(detector.withdrawal, 0.0) + limits.max_acceleration * dt;
  return moved > speed * dt;
}

/// Follows contact and deflection through the tick.
Course follow_contact(const TouchLimits& limits, const StringTouch& touch,
                      ReleaseDetector& detector) noexcept {
  const bool contact = touch.distance < 0.0;
  const double deflection = contact && limits.can_arm ? touch.deflection : 0.0;
  const double dt = static_cast<double>(touch.time.dt_ns) * kSecondsPerNanosecond;
  const bool lost = detector.contact && !contact;

  Course course{0.0, contact ? 1.0 : 0.0, deflection - detector.deflection};
  if (contact && !detector.contact) course.from = crossing(touch, 0.0);
  if (lost) {
    course.to = crossing(touch, 0.0);
    detector.slipped = slips(limits, touch, dt, detector);
    if (detector.slipped) course.from = course.to;
  }

  if (lost) detector.lost_deflection = detector.deflection;
  detector.contact = contact;
  detector.deflection = deflection;
  return course;
}

/// Share of the tick at which the deflection passed `threshold`, to end at `deflection`.
double arming(const Course& rise, double deflection, double threshold) noexcept {
  const double missing = deflection - threshold;
  const double share = rise.change > missing ? 1.0 - missing / rise.change : 0.0;
  return rise.from + share * (rise.to - rise.from);
}

}  // namespace

TouchReport watch_touch(const TouchLimits& limits, const StringTouch& touch,
                        ReleaseDetector& detector) noexcept {
  TouchReport report;
  const TickTime& time = touch.time;
  // What the tool touches: the string, or the envelope it vibrates in once the tool has been out of
  // it. An armed touch ends where it leaves the string, however that rings.
  const bool reaches = detector.touching ? !detector.armed : detector.outside;
  const double boundary = reaches ? limits.envelope : 0.0;
  const bool inside = touch.distance < boundary;

  if (!detector.touching) {
    if (!inside) {
      detector.outside = detector.outside || touch.distance >= limits.envelope;
      return report;
    }
    const ReleaseDetector last = detector;
    detector = ReleaseDetector{};
    detector.sounded = last.sounded;
    detector.sounded_ns = last.sounded_ns;
    detector.touching = true;
    detector.inside = true;
    detector.outside = false;
    report.began = true;
    report.began_ns = instant(time, crossing(touch, boundary));
  }

  const Course course = follow_contact(limits, touch, detector);
  if (detector.contact) {
    detector.largest_force = std::max(detector.largest_force, touch.force);
    detector.largest_deflection = std::max(detector.largest_deflection, detector.deflection);
  }
  const double threshold = limits.release.arm_deflection;
  if (limits.can_arm && !detector.armed && detector.deflection > threshold) {
    detector.armed = report.armed = true;
    report.armed_ns = instant(time, arming(course, detector.deflection, threshold));
  }

  if (inside) {
    detector.lambda = touch.lambda;
  } else if (detector.inside) {
    detector.lost_ns = instant(time, crossing(touch, boundary));
    detector.normal_speed = touch.normal_speed;
    detector.tangential_speed = touch.tangential_speed;
  }
  detector.inside = inside;
  detector.withdrawal = (touch.distance - touch.distance_before) /
                        (static_cast<double>(time.dt_ns) * kSecondsPerNanosecond);

  if (!inside && touch.distance > boundary + limits.release.release_gap) {
    report.ended = true;
    report.released = detector.armed;
    report.ended_ns = detector.lost_ns;
    detector.touching = false;
    detector.armed = false;
    detector.outside = touch.distance >= limits.envelope;
  }
  return report;
}

std::int64_t touched_ns(const ReleaseDetector& detector, const TickTime& now) noexcept {
  return detector.inside ? now.t_ns : detector.lost_ns;
}

bool refractory(const ReleaseOptions& options, const ReleaseDetector& detector,
                std::int64_t t_ns) noexcept {
  if (!detector.sounded) return false;
  const auto since = static_cast<double>(t_ns - detector.sounded_ns);
  return since < options.refractory * kNanosecondsPerSecond;
}

}  // namespace hapticd
