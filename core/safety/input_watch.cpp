// Judging samples. See input_watch.h. RT: yes.
#include "core/safety/input_watch.h"

#include <algorithm>
#include <cmath>

#include "core/math/rotation.h"

namespace hapticd {
namespace {

bool finite(const Array3& a) noexcept {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

/// A sample that can be computed with.
bool sound(const WatchedSample& sample) noexcept {
  if (!finite(sample.p_DH)) return false;
  for (const double x : sample.p_DH) {
    if (std::abs(x) > kMaxSamplePosition) return false;
  }
  double square = 0.0;
  for (const double x : sample.q_DH) square += x * x;
  // Written so that NaN fails.
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

WatchedInput bridge(const InputLimits& limits, bool refused, InputWatch& state) noexcept {
  ++state.missed_ticks;
  if (refused) {
    ++state.bad_ticks;
    ++state.bad_total;
  }
  state.V_DH_D = {};
  WatchedInput result;
  result.X_DH = state.X_DH;
  result.held = true;
  if (state.bad_ticks > kHeldTicks) {
    result.fault = Cause::kNotFinite;
  } else if (state.missed_ticks > limits.stale_ticks) {
    result.fault = Cause::kInputStale;
  }
  result.usable = state.has_pose && result.fault == Cause::kNone;
  if (result.usable) ++state.held_total;
  return result;
}

/// The motion since the last good sample; none for the first.
void find_motion(const WatchedSample& sample, const Pose& X_DH, const InputWatch& state,
                 WatchedInput& result) noexcept {
  if (!state.has_pose) return;
  result.displacement_D = {X_DH.p - state.X_DH.p, turned(X_DH.q, state.X_DH.q)};
  if (sample.t_ns > state.t_ns) {
    const double dt_s = (static_cast<double>(sample.t_ns) - static_cast<double>(state.t_ns)) * 1e-9;
    result.elapsed_s = dt_s;
    result.V_DH_D = {result.displacement_D.v / dt_s, result.displacement_D.w / dt_s};
  }
}

/// True when the pose has repeated for too long under force.
bool is_stuck(const WatchedSample& sample, const Pose& X_DH, double force_written,
              const InputLimits& limits, InputWatch& state) noexcept {
  const bool repeats =
      state.has_pose && X_DH.p == state.X_DH.p && X_DH.q.coeffs() == state.X_DH.q.coeffs();
  if (!repeats || !(force_written >= limits.stuck_force)) {
    state.still_since_ns = sample.t_ns;
    return false;
  }
  return limits.stuck_after_ns > 0 && sample.t_ns - state.still_since_ns > limits.stuck_after_ns;
}

}  // namespace

int bridged_ticks(double device_rate, double tick_rate) noexcept {
  constexpr double kMost = 1e6;
  const double ticks_per_sample = tick_rate / device_rate;
  if (!(ticks_per_sample > 1.0)) return kHeldTicks;
  return static_cast<int>(std::ceil(kHeldTicks * std::min(ticks_per_sample, kMost)));
}

WatchedInput watch(const WatchedSample& sample, double force_written, const InputLimits& limits,
                   InputWatch& state) noexcept {
  const bool refused = sample.fresh && !sound(sample);
  const bool old = state.has_pose && sample.counter <= state.counter;
  if (!sample.fresh || refused || old) return bridge(limits, refused, state);
  WatchedInput result;
  result.usable = true;
  result.X_DH = {renormalised(to_quaternion(sample.q_DH)), to_vector(sample.p_DH)};
  find_motion(sample, result.X_DH, state, result);
  const double seen_speed = result.V_DH_D.v.norm();
  if (sample.has_velocity) result.V_DH_D = {to_vector(sample.v_DH_D), to_vector(sample.w_DH_D)};
  // Whichever is faster: a wrong tachometer must not hide a jump, nor a held pose a speed.
  if (!(std::max(seen_speed, result.V_DH_D.v.norm()) <= limits.velocity_trip)) {
    ++state.fast_total;
    result.fault = Cause::kVelocityTrip;
  }
  if (is_stuck(sample, result.X_DH, force_written, limits, state)) {
    result.fault = Cause::kInputStuck;
  }
  state.X_DH = result.X_DH;
  state.V_DH_D = result.V_DH_D;
  state.t_ns = sample.t_ns;
  state.counter = sample.counter;
  state.has_pose = true;
  state.missed_ticks = 0;
  state.bad_ticks = 0;
  return result;
}

}  // namespace hapticd
