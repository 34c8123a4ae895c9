// Judges samples. See pose_guard.h. RT: yes.
#include "core/safety/pose_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/rotation.h"

namespace hapticd {
namespace {

bool finite(const Array3& a) noexcept {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

/// A sample that can be computed with. Written so that NaN fails.
bool sound(const DeviceSample& sample, double reach) noexcept {
  if (!(to_vector(sample.p_DH).norm() <= reach)) return false;
  double square = 0.0;
  for (const double x : sample.q_DH) square += x * x;
  if (!(square >= kMinSampleQuaternionNorm * kMinSampleQuaternionNorm &&
        square <= kMaxSampleQuaternionNorm * kMaxSampleQuaternionNorm)) {
    return false;
  }
  return !sample.has_velocity || (finite(sample.v_DH_D) && finite(sample.w_DH_D));
}

/// Rotation vector in D from q_prev to q.
Vector3 turned(const Quaternion& q, const Quaternion& q_prev) noexcept {
  return log_rotation(renormalised(q * q_prev.conjugate()));
}

JudgedPose bridge(const GuardLimits& limits, bool refused, PoseGuard& guard) noexcept {
  ++guard.missed_ticks;
  if (refused) {
    ++guard.bad_ticks;
    ++guard.bad_total;
  }
  JudgedPose result;
  const bool lost = guard.has_pose && !(guard.X_DH.p.norm() <= limits.reach);
  if (lost) guard.has_pose = false;
  result.t_ns = guard.t_ns;
  result.X_DH = guard.X_DH;
  result.held = true;
  if (lost || guard.bad_ticks > kHeldTicks) {
    result.fault = Cause::kNotFinite;
  } else if (guard.missed_ticks > limits.stale_ticks && (guard.has_pose || !limits.may_wait)) {
    result.stale = guard.has_pose && guard.missed_ticks <= limits.stale_ticks + limits.fading_ticks;
    if (!result.stale) result.fault = Cause::kInputStale;
  }
  result.usable = guard.has_pose && result.fault == Cause::kNone;
  if (result.usable) ++guard.held_total;
  return result;
}

/// Reports that a gap in the counter stands for, at most: as many as a system queues. More says
/// nothing of time.
constexpr std::uint64_t kMaxReports = 64;
/// No device is slower, ns: it only keeps sums within range.
constexpr std::int64_t kMaxReport_ns = 1'000'000'000;

/// `by` >= 0 after `t_ns`, or the last instant there is.
std::int64_t after(std::int64_t t_ns, std::int64_t by_ns) noexcept {
  constexpr std::int64_t kLast_ns = std::numeric_limits<std::int64_t>::max();
  return t_ns > kLast_ns - by_ns ? kLast_ns : t_ns + by_ns;
}

std::int64_t interval_of(const GuardLimits& limits) noexcept {
  return std::clamp<std::int64_t>(limits.report_interval_ns, 0, kMaxReport_ns);
}

/// When the sample was made. Never before its own time, and a report interval after the one before
/// for each that was made since: readings crowd, reports do not. At most two intervals past its own
/// time, so that an interval stated too long does not run away and hide a speed.
std::int64_t made_at(const DeviceSample& sample, const GuardLimits& limits,
                     const PoseGuard& guard) noexcept {
  if (!guard.has_pose) return sample.t_ns;
  const std::int64_t interval_ns = interval_of(limits);
  const auto reports =
      static_cast<std::int64_t>(std::min(sample.counter - guard.counter, kMaxReports));
  return std::max(sample.t_ns, std::min(after(guard.t_ns, reports * interval_ns),
                                        after(sample.t_ns, 2 * interval_ns)));
}

/// The motion since the last good sample; none for the first.
void find_motion(const PoseGuard& guard, JudgedPose& result) noexcept {
  if (!guard.has_pose) return;
  result.displacement_D = {result.X_DH.p - guard.X_DH.p, turned(result.X_DH.q, guard.X_DH.q)};
  if (result.t_ns > guard.t_ns) {
    const double dt_s = (static_cast<double>(result.t_ns) - static_cast<double>(guard.t_ns)) * 1e-9;
    result.elapsed_s = dt_s;
    result.V_DH_D = {result.displacement_D.v / dt_s, result.displacement_D.w / dt_s};
  }
}

/// True when the motion just found, or what the device says of it, is too fast.
bool is_too_fast(const DeviceSample& sample, const GuardLimits& limits, const PoseGuard& guard,
                 const JudgedPose& result) noexcept {
  const double seen_speed = result.V_DH_D.v.norm();
  const double told_speed = sample.has_velocity ? to_vector(sample.v_DH_D).norm() : 0.0;
  // Whichever is faster: a wrong tachometer must not hide a jump, nor a held pose a speed.
  const bool fast = !(std::max(seen_speed, told_speed) <= limits.velocity_trip);
  if (!fast || !limits.loses_unseen) return fast;
  const double lost_s = 1e-9 * static_cast<double>(interval_of(limits));
  const double at_least = result.displacement_D.v.norm() / (result.elapsed_s + lost_s);
  return !(std::max(at_least, told_speed) <= limits.velocity_trip) ||
         !(guard.V_DH_D.v.norm() <= limits.velocity_trip);
}

/// True when the pose is the last one.
bool repeats(const Pose& X_DH, const PoseGuard& guard) noexcept {
  return guard.has_pose && X_DH.p == guard.X_DH.p && X_DH.q.coeffs() == guard.X_DH.q.coeffs();
}

/// True when a hand under force has been `still` for too long.
bool is_stuck(bool still, std::int64_t t_ns, const GuardLimits& limits, PoseGuard& guard) noexcept {
  if (!still) {
    guard.still_since_ns = t_ns;
    return false;
  }
  return limits.stuck_after_ns > 0 && t_ns - guard.still_since_ns > limits.stuck_after_ns;
}

}  // namespace

int bridged_ticks(double device_rate, double tick_rate) noexcept {
  constexpr double kMax = 1e6;
  const double ticks_per_sample = tick_rate / device_rate;
  if (!(ticks_per_sample > 1.0)) return kHeldTicks;
  return static_cast<int>(std::ceil(kHeldTicks * std::min(ticks_per_sample, kMax)));
}

bool usable(const PoseGuard& guard) noexcept {
  constexpr double kRounding = 1e-6;
  return guard.X_DH.p.allFinite() && std::abs(guard.X_DH.q.norm() - 1.0) <= kRounding;
}

JudgedPose judge(const DeviceSample* sample, double force_written, const GuardLimits& limits,
                 PoseGuard& guard) noexcept {
  const bool refused = sample != nullptr && !sound(*sample, limits.reach);
  const bool old = sample != nullptr && guard.has_pose && sample->counter <= guard.counter;
  if (sample == nullptr || refused || old) return bridge(limits, refused, guard);
  JudgedPose result;
  result.usable = true;
  result.X_DH = {renormalised(to_quaternion(sample->q_DH)), to_vector(sample->p_DH)};
  result.t_ns = made_at(*sample, limits, guard);
  find_motion(guard, result);
  if (is_too_fast(*sample, limits, guard, result)) {
    ++guard.fast_total;
    result.fault = Cause::kVelocityTrip;
  }
  if (sample->has_velocity) result.V_DH_D = {to_vector(sample->v_DH_D), to_vector(sample->w_DH_D)};
  const bool still = force_written >= limits.stuck_force && repeats(result.X_DH, guard);
  if (is_stuck(still, sample->t_ns, limits, guard)) {
    result.fault = Cause::kInputStuck;
  }
  guard.X_DH = result.X_DH;
  guard.V_DH_D = result.V_DH_D;
  guard.t_ns = result.t_ns;
  guard.counter = sample->counter;
  guard.has_pose = true;
  guard.missed_ticks = 0;
  guard.bad_ticks = 0;
  return result;
}

}  // namespace hapticd
