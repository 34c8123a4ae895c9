// See simulated_device.h.
#include "device/simulated/simulated_device.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "core/safety/pose_guard.h"
#include "core/safety/wrench_limit.h"
#include "core/tick/sample_difference.h"
#include "device/api/command_check.h"

namespace hapticd {
namespace {

constexpr double kPlantStep = static_cast<double>(kPlantStep_ns) * 1e-9;
constexpr double kTargetStep = static_cast<double>(kTargetStep_ns) * 1e-9;
/// So much longer than the delay a pose is remembered that a command may be about, s.
constexpr double kRemembered = 0.02;
/// What has died away to less than this, in any unit, is 0: what halves for ever ends in subnormal
/// numbers, with which a tick takes half as long again. Products of up to ten such are normal yet:
/// turns of that size are multiplied, and their products multiplied again.
constexpr double kAtRest = 1e-30;
/// Rounding of a command at its limit, relative: no saturation yet.
constexpr double kAtLimit = 1.0 + 1e-9;

constexpr Eigen::Index row(std::size_t axis) noexcept {
  return static_cast<Eigen::Index>(axis < 3 ? axis : axis - 3);
}

/// The three of `six` from `first` on.
Vector3 part(const std::array<double, 6>& six, std::size_t first) noexcept {
  return {six[first], six[first + 1], six[first + 2]};
}

void set_part(std::array<double, 6>& six, std::size_t first, const Vector3& v) noexcept {
  for (std::size_t i = 0; i < 3; ++i) six[first + i] = v[row(i)];
}

/// The nearest multiple of `step`; the value itself where step is 0.
double quantised(double value, double step) noexcept {
  return step > 0.0 ? std::floor(value / step + 0.5) * step : value;
}

double at_rest_or(double value) noexcept { return std::abs(value) < kAtRest ? 0.0 : value; }

AxisPlant plant_of(const DeviceProfile& profile, const ArmModel& arm, std::size_t axis) noexcept {
  if (axis < 3) {
    return {profile.mass[axis] + arm.mass, profile.damping, arm.damping, arm.stiffness,
            profile.coulomb_friction[axis]};
  }
  const std::size_t i = axis - 3;
  return {profile.inertia[i] + arm.inertia, profile.rotational_damping[i], arm.rotational_damping,
          arm.rotational_stiffness, profile.coulomb_torque[i]};
}

}  // namespace

SimulatedDevice::SimulatedDevice(const DeviceProfile& profile, const SimulatedOptions& options)
    : profile_(profile),
      arms_(options.arms),
      commands_(profile.delay, profile.watchdog),
      player_(options.X_DH),
      arm_(known_arm(options.arm)),
      seed_(options.seed),
      X_DH_begin_{renormalised(options.X_DH.q), options.X_DH.p},
      report_ns_(std::max(kPlantStep_ns, static_cast<std::int64_t>(1e9 / profile.report_rate))) {
  for (std::size_t kind = 0; kind < kArmKinds; ++kind) {
    for (std::size_t axis = 0; axis < 6; ++axis) {
      responses_[kind][axis] = make_axis_response(plant_of(profile, arms_[kind], axis), kPlantStep);
    }
  }
  if (profile.motor_lag > 0.0) {
    const double ratio = kPlantStep / profile.motor_lag;
    motor_decay_ = exponential(-ratio);
    motor_share_ = (1.0 - motor_decay_) / ratio;
  }
  const double delay = arms_[index_of(ArmKind::kAdversarial)].delay;
  felt_.resize(1 + static_cast<std::size_t>(std::ceil(delay / kTargetStep)));
  if (profile.affine) {
    const double samples = (profile.delay + kRemembered) / (1e-9 * static_cast<double>(report_ns_));
    sampled_.resize(2 + static_cast<std::size_t>(samples));
  }
  set_seed(options.seed);
  place(options.X_DH);
}

void SimulatedDevice::place(const Pose& X_DH) noexcept {
  q_DH_ = renormalised(X_DH.q);
  p_DH_ = X_DH.p;
  moved_ = v_ = y_ = v_target_ = {};
  X_DH_target_ = {q_DH_, p_DH_};
  player_.rest_at(X_DH_target_);
  into_target_ns_ = 0;
}

void SimulatedDevice::set_seed(std::uint64_t seed) noexcept {
  seed_ = seed;
  const ArmModel& model = arms_[index_of(arm_)];
  tremor_ = Tremor(seed, model.tremor, model.tremor_frequency, kTargetStep);
}

void SimulatedDevice::set_arm(ArmKind kind) noexcept {
  const ArmKind arm = known_arm(kind);
  if (arm == arm_) return;
  if (arm_ == ArmKind::kOff) {
    // The hand closes around a handle that may have drifted: it holds it where it is.
    player_.rest_at(pose());
    X_DH_target_ = player_.target();
  }
  arm_ = arm;
  set_seed(seed_);
}

void SimulatedDevice::play(const GestureTrack& track, std::uint32_t repeat) noexcept {
  player_.play(track, repeat);
}

Pose SimulatedDevice::pose() const noexcept {
  return {renormalised(exp_rotation(part(moved_, 3)) * q_DH_), p_DH_};
}

bool SimulatedDevice::sound() const noexcept {
  const auto finite = [](const Six& six) {
    return std::all_of(six.begin(), six.end(), [](double x) { return std::isfinite(x); });
  };
  const auto near = [](const Pose& X) {
    return X.p.cwiseAbs().maxCoeff() <= kMaxPosition && X.q.coeffs().allFinite();
  };
  return p_DH_.allFinite() && near({q_DH_, p_DH_}) && X_DH_target_.p.allFinite() &&
         near(X_DH_target_) && finite(moved_) && finite(v_) && finite(y_) && finite(v_target_) &&
         finite(motor_) && finite(reaction_) && std::all_of(felt_.begin(), felt_.end(), finite);
}

bool SimulatedDevice::recover() noexcept {
  if (sound()) return false;
  place(X_DH_begin_);
  motor_ = reaction_ = {};
  std::fill(felt_.begin(), felt_.end(), Six{});
  std::fill(sampled_.begin(), sampled_.end(), X_DH_begin_);
  in_force_ = {};
  set_seed(seed_);
  // Velocity is the difference to the last sample.
  last_.p_DH = to_array(X_DH_begin_.p);
  last_.q_DH = to_array(X_DH_begin_.q);
  return true;
}

PlantState SimulatedDevice::plant() const noexcept {
  PlantState state;
  state.t_ns = t_ns_;
  state.X_DH = pose();
  state.V_DH = {part(v_, 0), part(v_, 3)};
  state.F_H_D = {part(motor_, 0), part(motor_, 3)};
  state.X_DH_target = X_DH_target_;
  const ArmModel& model = arms_[index_of(arm_)];
  for (std::size_t axis = 0; axis < 6; ++axis) {
    state.energy += 0.5 * plant_of(profile_, model, axis).mass * v_[axis] * v_[axis];
  }
  return state;
}

void SimulatedDevice::begin_target_step() noexcept {
  const Pose X_DH{q_DH_, p_DH_};
  const Pose from = X_DH_target_;
  const Pose& asked = player_.advance(kTargetStep_ns);
  felt_[felt_next_] = motor_;
  felt_next_ = (felt_next_ + 1) % felt_.size();
  reaction_ = {};
  if (arm_ == ArmKind::kOff) {
    if (!player_.progress().playing) player_.rest_at(X_DH);
    X_DH_target_ = X_DH;
    y_ = v_target_ = {};
    return;
  }
  // The ring holds exactly as many steps that the oldest is the one to react to.
  if (arm_ == ArmKind::kAdversarial) reaction_ = felt_[felt_next_];
  X_DH_target_ = {asked.q, asked.p + tremor_.next()};
  set_part(y_, 0, X_DH.p - from.p);
  set_part(y_, 3, log_rotation(X_DH.q * from.q.conjugate()));
  set_part(v_target_, 0, (X_DH_target_.p - from.p) / kTargetStep);
  set_part(v_target_, 3, log_rotation(X_DH_target_.q * from.q.conjugate()) / kTargetStep);
}

void SimulatedDevice::end_target_step() noexcept {
  q_DH_ = renormalised(exp_rotation(part(moved_, 3)) * q_DH_);
  set_part(moved_, 3, Vector3::Zero());
  into_target_ns_ = 0;
}

// f0 + K (p_ref - p) and t0 + Kr e, e the rotation back to the pose of the sample.
Wrench SimulatedDevice::commanded() const noexcept {
  Wrench F = in_force_.F_H_D;
  const std::uint64_t back = last_.counter - in_force_.sample_counter;
  if (is_none(in_force_.spring) || back >= sampled_.size()) return F;
  const Pose& X_ref = sampled_[in_force_.sample_counter % sampled_.size()];
  const Pose X_DH = pose();
  const auto& [xx, yy, zz, xy, xz, yz] = in_force_.spring.K_D;
  const Vector3 way = X_ref.p - X_DH.p;
  F.f += Vector3(xx * way.x() + xy * way.y() + xz * way.z(),
                 xy * way.x() + yy * way.y() + yz * way.z(),
                 xz * way.x() + yz * way.y() + zz * way.z());
  F.t += to_vector(in_force_.spring.Kr_D).cwiseProduct(log_rotation(X_ref.q * X_DH.q.conjugate()));
  return F;
}

SimulatedDevice::Six SimulatedDevice::motor_mean(const Wrench& F_H_D) noexcept {
  const double force = profile_.actuated_axes > 0 ? profile_.peak_force : 0.0;
  const double torque = profile_.actuated_axes > 3 ? profile_.peak_torque : 0.0;
  const Wrench given = limited(F_H_D, {force, torque});
  saturated_ = F_H_D.f.norm() > force * kAtLimit || F_H_D.t.norm() > torque * kAtLimit;
  Six mean{};
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const double asked = axis < 3 ? given.f[row(axis)] : given.t[row(axis)];
    const double behind = motor_[axis] - asked;
    mean[axis] = asked + motor_share_ * behind;
    motor_[axis] = asked + at_rest_or(motor_decay_ * behind);
  }
  return mean;
}

void SimulatedDevice::sub_step() noexcept {
  if (into_target_ns_ == 0) begin_target_step();
  in_force_ = commands_.at(t_ns_);
  note_echo(in_force_.sample_counter, t_ns_, echo_);
  const Six motor = motor_mean(commanded());
  const Responses& responses = responses_[index_of(arm_)];
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const AxisStep step = advance_axis(responses[axis], {y_[axis], v_[axis], v_target_[axis]},
                                       motor[axis] + reaction_[axis]);
    v_[axis] = at_rest_or(step.v);
    if (axis < 3) {
      p_DH_[row(axis)] += step.moved;
    } else {
      moved_[axis] += step.moved;
    }
    if (arm_ != ArmKind::kOff) {
      y_[axis] = at_rest_or(y_[axis] + (step.moved - v_target_[axis] * kPlantStep));
    }
  }
  t_ns_ += kPlantStep_ns;
  into_target_ns_ += kPlantStep_ns;
  if (into_target_ns_ == kTargetStep_ns) end_target_step();
}

void SimulatedDevice::advance_to(std::int64_t now_ns) noexcept {
  const std::int64_t behind_ns = now_ns - t_ns_ - kMaxCatchUp_ns;
  if (behind_ns > 0) t_ns_ += (behind_ns + kPlantStep_ns - 1) / kPlantStep_ns * kPlantStep_ns;
  while (now_ns - t_ns_ >= kPlantStep_ns) sub_step();
}

std::uint16_t SimulatedDevice::flags() const noexcept {
  unsigned flags = kDeviceAttached | kDeviceCalibrated;
  if (in_force_.enabled) flags |= kDeviceEnabled;
  if (in_force_.stale) flags |= kDeviceWatchdogFired;
  if (saturated_) flags |= kDeviceSaturated;
  return static_cast<std::uint16_t>(flags);
}

void SimulatedDevice::measure(DeviceSample& sample) noexcept {
  const Pose X_DH = pose();
  DeviceSample next;
  next.t_ns = t_ns_;
  next.counter = last_.counter + 1;
  note_sample(next.counter, next.t_ns, echo_);
  if (echo_.estimator.estimate_ns >= 0) {
    next.measured_delay_s = 1e-9 * static_cast<double>(echo_.estimator.estimate_ns);
  }
  bool exact = true;
  for (std::size_t i = 0; i < 3; ++i) {
    next.p_DH[i] = quantised(X_DH.p[row(i)], profile_.position_resolution[i]);
    exact = exact && profile_.position_resolution[i] == 0.0;
    exact = exact && profile_.rotation_resolution[i] == 0.0;
  }
  Vector3 phi = log_rotation(X_DH.q);
  for (std::size_t i = 0; i < 3; ++i) {
    phi[row(i)] = quantised(phi[row(i)], profile_.rotation_resolution[i]);
  }
  next.q_DH = to_array(exact ? X_DH.q : renormalised(exp_rotation(phi)));
  next.flags = flags();
  // Encoders see positions alone; a device without encoder steps is the ideal one.
  next.has_velocity = exact;
  if (exact) {
    next.v_DH_D = to_array(part(v_, 0));
    next.w_DH_D = to_array(part(v_, 3));
  } else if (last_.counter > 0) {
    difference_velocity(last_, next);
  }
  if (!sampled_.empty()) sampled_[next.counter % sampled_.size()] = X_DH;
  sample = last_ = next;
}

ReadOutcome SimulatedDevice::read(std::int64_t now_ns, DeviceSample& sample) noexcept {
  if (!begun_) {
    begun_ = true;
    t_ns_ = due_ns_ = now_ns;
  }
  advance_to(now_ns);
  // A reader half a period early still gets the sample, so that its jitter costs none.
  if (now_ns < due_ns_ - report_ns_ / 2) return ReadOutcome::kNothing;
  due_ns_ += report_ns_;
  if (due_ns_ <= now_ns) due_ns_ += (now_ns - due_ns_) / report_ns_ * report_ns_ + report_ns_;
  measure(sample);
  return ReadOutcome::kFresh;
}

bool SimulatedDevice::write(std::int64_t now_ns, const DeviceCommand& command) noexcept {
  if (is_finite(command)) return commands_.send(now_ns, command);
  DeviceCommand zero = command;
  zero.f_H_D = zero.t_H_D = {};
  zero.spring = {};
  commands_.send(now_ns, zero);
  return false;
}

void SimulatedDevice::write_zero(std::int64_t now_ns) noexcept { commands_.send_zero(now_ns); }

}  // namespace hapticd
