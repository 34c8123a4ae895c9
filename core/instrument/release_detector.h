// When a string is touched, armed and let go. With hysteresis: a touch arms above a deflection and
// ends beyond a gap, so that noise neither plucks nor flickers. What a release leaves ringing is
// the largest deflection of its touch, however slowly the hand has lifted (r_max of the paper's Eq.
// 9).
//
// Where in a tick: contact begins and ends where the distance, linear between its samples, crosses
// zero; delta rises from there. SI. RT: yes, 20 ns while touched.
#pragma once

#include <cstdint>

#include "core/instrument/instrument_options.h"
#include "core/instrument/string_parameters.h"
#include "core/instrument/string_touch.h"
#include "core/math/realtime.h"

namespace hapticd {

/// Watches the touch of one string. Valid from construction: no touch.
struct ReleaseDetector {
  bool touching = false;  ///< a touch has begun and not ended
  bool inside = false;    ///< the tool is nearer than what it touches: contact, or the envelope
  bool contact = false;   ///< it presses the string
  bool armed = false;     ///< letting go plucks
  /// The tool has been out of the envelope since the last touch: entering it is a touch again.
  bool outside = true;
  bool slipped = false;             ///< the last loss of contact was faster than the hand
  double deflection = 0.0;          ///< in the last tick, m
  double force = 0.0;               ///< largest |F_d| of the touch, N
  double normal_speed = 0.0;        ///< tool against string in the tick of the loss, m/s
  double tangential_speed = 0.0;    ///< likewise
  double lambda = 0.5;              ///< place of the last contact, as the touch has it
  double withdrawal = 0.0;          ///< speed of the distance in the last tick, m/s
  double largest_force = 0.0;       ///< of the touch, N
  double largest_deflection = 0.0;  ///< of the touch, m
  double lost_deflection = 0.0;     ///< before the last loss of contact, m
  std::int64_t lost_ns = 0;         ///< instant of the last loss
  bool sounded = false;             ///< a release has sounded, at sounded_ns
  std::int64_t sounded_ns = 0;      ///< begins the refractory time
};

/// What changed in a tick, with the instants.
struct TouchReport {
  bool began = false;
  bool armed = false;     ///< in this tick
  bool ended = false;     ///< what the detector keeps of the touch stays until the next begins
  bool released = false;  ///< the touch that ended was armed
  std::int64_t began_ns = 0;
  std::int64_t armed_ns = 0;
  std::int64_t ended_ns = 0;  ///< the loss of contact, in this tick or an earlier one
};

/// How a touch is recognised.
struct TouchLimits {
  ReleaseOptions release;
  double envelope = 0.0;            ///< reach of the vibration at the place of the touch, m, >= 0
  bool can_arm = true;              ///< false: the string does not yield
  double max_acceleration = 500.0;  ///< of the hand, m/s^2: a slip or a withdrawal
};

/// One tick. touch.time.dt_ns > 0.
HD_REALTIME TouchReport watch_touch(const TouchLimits& limits, const StringTouch& touch,
                                    ReleaseDetector& detector) noexcept;

/// When the tool was last nearer than what it touches, ns, once it has been.
[[nodiscard]] HD_REALTIME std::int64_t touched_ns(const ReleaseDetector& detector,
                                                  const TickTime& now) noexcept;

/// True if a release at t_ns comes too soon after one that sounded to sound again.
[[nodiscard]] HD_REALTIME bool refractory(const ReleaseOptions& options,
                                          const ReleaseDetector& detector,
                                          std::int64_t t_ns) noexcept;

}  // namespace hapticd
