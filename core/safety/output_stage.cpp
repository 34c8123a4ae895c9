// The last stage before a device. See output_stage.h. RT: yes.
#include "core/safety/output_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/safety/slew_limit.h"

namespace hapticd {
namespace {

/// Times and budgets are cut to these, s and J: they only keep products finite.
constexpr double kMaxDt_s = 1e3;
constexpr double kMaxBudget = 1e3;
/// Motions are cut to this per component, m, rad, m/s and rad/s, for the same reason.
constexpr double kMaxMotion = 1e9;

bool finite(const SafetyInput& input) noexcept {
  return input.F_H_D.f.allFinite() && input.F_H_D.t.allFinite() && input.V_DH_D.v.allFinite() &&
         input.V_DH_D.w.allFinite() && input.displacement_D.v.allFinite() &&
         input.displacement_D.w.allFinite() && std::isfinite(input.dt_s) &&
         std::isfinite(input.hold_s) && std::isfinite(input.gain) && std::isfinite(input.budget);
}

Twist bounded(const Twist& V) noexcept {
  return {V.v.cwiseMax(-kMaxMotion).cwiseMin(kMaxMotion),
          V.w.cwiseMax(-kMaxMotion).cwiseMin(kMaxMotion)};
}

/// All but the wrench.
SafetyInput bounded(const SafetyInput& input) noexcept {
  SafetyInput kept = input;
  kept.dt_s = std::clamp(input.dt_s, 0.0, kMaxDt_s);
  kept.hold_s = std::clamp(input.hold_s, 0.0, kMaxDt_s);
  kept.gain = std::clamp(input.gain, 0.0, 1.0);
  kept.V_DH_D = bounded(input.V_DH_D);
  kept.displacement_D = bounded(input.displacement_D);
  kept.budget = std::clamp(input.budget, 0.0, kMaxBudget);
  kept.flight = std::clamp(input.flight, 0, kMostFlight);
  return kept;
}

ThermalRating force_rating(const SafetyLimits& limits) noexcept {
  return {limits.continuous_force, limits.thermal_window_s};
}

ThermalRating torque_rating(const SafetyLimits& limits) noexcept {
  return {limits.continuous_torque, limits.thermal_window_s};
}

Vector3 thermally_limited(const Vector3& F, const ThermalRating& rating, const ThermalLoad& load,
                          std::uint32_t& flags) noexcept {
  const double size = F.norm();
  const double allowed = allowed_size(rating, load);
  if (size <= allowed) return F;
  flags |= kSafetyThermal;
  return F * (allowed / size);
}

/// The enabled wrench of a tick whose input is finite and bounded.
Wrench shaped(const SafetyInput& input, const SafetyLimits& limits, SafetyState& state,
              std::uint32_t& flags) noexcept {
  const Wrench computed = limited(input.F_H_D, {kMaxComputedWrench, kMaxComputedWrench});
  const double removed = state.port.removed;
  PassivityControl control(limits.passivity, input.budget, state.port, input.flight);
  Wrench F =
      control.faded({computed.f * input.gain, computed.t * input.gain}, input.V_DH_D, input.hold_s);
  F = control.damped(F, input.V_DH_D, input.hold_s);
  if (state.port.removed > removed || state.port.share < 1.0) flags |= kSafetyPassivity;
  const double growth_s = std::min(input.dt_s, kMaxSlewStep_s);
  bool slew_limited = false;
  F = {slewed(F.f, to_vector(state.f_H_D), kForceSlew * growth_s, slew_limited),
       slewed(F.t, to_vector(state.t_H_D), kTorqueSlew * growth_s, slew_limited)};
  if (slew_limited) flags |= kSafetySlew;
  // After the slew, which may turn a wrench: the bound must hold for what is written.
  const double share = control.energy_share(F, input.V_DH_D, input.hold_s);
  if (share < 1.0) flags |= kSafetyPassivity;
  F = {F.f * share, F.t * share};
  F.f = thermally_limited(F.f, force_rating(limits), state.force_load, flags);
  F.t = thermally_limited(F.t, torque_rating(limits), state.torque_load, flags);
  if (F.f.norm() > limits.peak.force || F.t.norm() > limits.peak.torque) flags |= kSafetySaturated;
  return limited(F, limits.peak);
}

}  // namespace

bool usable(const SafetyLimits& limits) noexcept {
  const PassivityLimits& port = limits.passivity;
  const double numbers[] = {limits.peak.force,      limits.peak.torque, limits.thermal_window_s,
                            port.allowance,         port.soft_share,    port.credit,
                            port.acceleration,      port.damping,       port.angular_acceleration,
                            port.rotational_damping};
  return std::all_of(std::begin(numbers), std::end(numbers),
                     [](double x) { return std::isfinite(x) && x >= 0.0; }) &&
         limits.thermal_window_s > 0.0 && limits.time_to_live_ns >= 0 &&
         limits.continuous_force >= 0.0 && limits.continuous_torque >= 0.0;
}

SafetyOutput limit(const SafetyInput& input, const SafetyLimits& limits,
                   SafetyState& state) noexcept {
  SafetyOutput output;
  const Wrench F_prev{to_vector(state.f_H_D), to_vector(state.t_H_D)};
  state.f_H_D = state.t_H_D = {};
  output.expires_ns = input.now_ns;
  if (!usable(limits) || !finite(input)) {
    output.flags = kSafetyNotFinite;
    return output;
  }
  const SafetyInput tick = bounded(input);
  PassivityControl port(limits.passivity, tick.budget, state.port, tick.flight);
  port.observe(F_prev, tick.displacement_D, tick.dt_s);
  add_load(F_prev.f.norm(), tick.dt_s, force_rating(limits), state.force_load);
  add_load(F_prev.t.norm(), tick.dt_s, torque_rating(limits), state.torque_load);
  if (!input.enable) {
    port.rest();
    return output;
  }
  state.f_H_D = to_array(F_prev.f);
  state.t_H_D = to_array(F_prev.t);
  const Wrench F = shaped(tick, limits, state, output.flags);
  state.f_H_D = output.f_H_D = to_array(F.f);
  state.t_H_D = output.t_H_D = to_array(F.t);
  output.enable = true;
  constexpr std::int64_t kEndOfTime_ns = std::numeric_limits<std::int64_t>::max();
  output.expires_ns = input.now_ns > kEndOfTime_ns - limits.time_to_live_ns
                          ? kEndOfTime_ns
                          : input.now_ns + limits.time_to_live_ns;
  return output;
}

}  // namespace hapticd
