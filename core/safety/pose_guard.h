// The one guard before anything computes with a pose: judges every sample of a device. It must be
// finite, within reach, with a usable quaternion, new, alive and not too fast. A bad or missing
// sample is bridged with the last good pose for at most two ticks. What is wrong is a cause of this
// tick; that a fault latches is for the loop's state machine to see to (loop_state.h). Poses X_DH
// and twists V_DH_D in the device's base D. Also the displacement the passivity observer integrates
// over: nothing is lost while a pose is held, the next good sample has all of it. Samples that
// carry the time of their reading are set apart by at least the time in which the device makes
// them. RT: yes, about 30 ns.
#pragma once

#include <cstdint>

#include "core/math/pose.h"
#include "core/math/realtime.h"
#include "core/math/wrench.h"
#include "core/tick/cause.h"
#include "core/tick/device_sample.h"

namespace hapticd {

/// Ticks a bad or missing sample is bridged where samples come as often as ticks. More: a force
/// computed from an old pose for longer; fewer: a fault at one glitch.
inline constexpr int kHeldTicks = 2;
/// |q| of a usable sample lies between these; it is then normalised.
inline constexpr double kMinSampleQuaternionNorm = 0.5;
inline constexpr double kMaxSampleQuaternionNorm = 2.0;
/// Positions of a tool further than this from the origin of W are garbage, not motion, m.
inline constexpr double kMaxPosition = 1e7;

/// What to look for.
struct GuardLimits {
  /// Largest |p_DH| of a good sample, m: that for which the tool stays within kMaxPosition
  /// (reach_of() of the workspace map).
  double reach = kMaxPosition;
  double velocity_trip = 3.0;  ///< m/s; the profile's
  /// From one report of the device to the next, ns, where samples carry the time of their reading:
  /// a late tick and the next read two of them 0.1 ms apart that were made a whole report apart. 0:
  /// the times are those of the samples themselves, and exact. Longer than it is: a speed shows one
  /// sample late; shorter: a late tick looks like a fast hand.
  std::int64_t report_interval_ns = 1'000'000;
  /// The counter misses reports that were lost on the way. One of those makes one sample look twice
  /// as fast, so a speed counts when it is too high even then, or twice in a row.
  bool loses_unseen = false;
  /// Ticks without a new sample that are bridged, see bridged_ticks(). A scripted device under the
  /// virtual clock may stand still for as long as it likes: kAnyTicks.
  int stale_ticks = kHeldTicks;
  /// Ticks without a new sample beyond those, in which the pose is held and told to be stale, so
  /// that the force can fade: of a stream of poses over a network, which pauses. 0: none.
  int fading_ticks = 0;
  /// Before its first sample a device may be silent for as long as it likes.
  bool may_wait = false;
  /// A pose that repeats to the bit for this long, by the device's clock, while a force of at least
  /// stuck_force is on, is a stuck sensor: a hand trembles by 0.1 mm at 8 to 12 Hz, several times
  /// any encoder's step, so two periods of that cannot pass without a change. Without force a
  /// handle may lie still for hours, and a stuck sensor harms nobody. 0: not looked for, as fits
  /// devices without sensors (simulated, scripted, replayed), which do repeat themselves.
  std::int64_t stuck_after_ns = 0;
  double stuck_force = 0.2;  ///< N
};

/// For GuardLimits::stale_ticks: a device that may be silent for ever.
inline constexpr int kAnyTicks = 1 << 30;

/// Two ticks, or as many as pass while two samples are missed by a device slower than the loop.
/// Rates in Hz, > 0 and finite; a rate that is not counts as equal.
[[nodiscard]] HD_REALTIME int bridged_ticks(double device_rate, double tick_rate) noexcept;

/// Kept from tick to tick.
struct PoseGuard {
  Pose X_DH;              ///< last good pose, unit quaternion
  Twist V_DH_D;           ///< its velocity; kept while a pose is held
  std::int64_t t_ns = 0;  ///< when it was made, at most two report intervals after it was read
  std::uint64_t counter = 0;
  bool has_pose = false;
  int missed_ticks = 0;             ///< ticks without a good sample, in a row
  int bad_ticks = 0;                ///< samples refused, since the last good one
  std::int64_t still_since_ns = 0;  ///< device time since which the pose repeats under force
  std::uint64_t bad_total = 0;      ///< samples refused
  std::uint64_t fast_total = 0;     ///< samples above the velocity trip
  std::uint64_t held_total = 0;     ///< ticks bridged
};

/// True when the pose of a state, which may come from a file, is one that judge() could have kept.
[[nodiscard]] bool usable(const PoseGuard& guard) noexcept;

/// What the tick works with.
struct JudgedPose {
  std::int64_t t_ns = 0;       ///< when it was made: PoseGuard::t_ns
  Pose X_DH;                   ///< good or held
  Twist V_DH_D;                ///< m/s, rad/s; by the device, else by difference of samples
  Twist displacement_D;        ///< since the tick before, m and rad (a rotation vector); zero while
                               ///< held
  double elapsed_s = 0.0;      ///< between the samples it spans, 0 while held
  bool held = false;           ///< the pose is not of this tick
  bool stale = false;          ///< held for longer than is bridged: the force is to fade
  bool usable = false;         ///< false: no pose yet, or bridged for too long; no force
  Cause fault = Cause::kNone;  ///< kNotFinite, kInputStale, kInputStuck or kVelocityTrip, present
                               ///< in this tick; see latches()
};

/// Judges the sample of one tick, where it is; null when none came. `force_written` is |f| of the
/// last wrench written, N. A pose that is held and has gone out of reach, because the map has
/// changed, is forgotten: kNotFinite, and none is usable until a good sample comes.
[[nodiscard]] HD_REALTIME JudgedPose judge(const DeviceSample* sample, double force_written,
                                           const GuardLimits& limits, PoseGuard& guard) noexcept;

}  // namespace hapticd
