// Largest stable stiffness. See stiffness_clamp.h. RT: yes.
#include "core/safety/stiffness_clamp.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

/// Factor that brings `stiffness` to `bound`; 0 for a stiffness that is none.
double factor(double stiffness, double bound) noexcept {
  if (!std::isfinite(stiffness) || stiffness < 0.0) return 0.0;
  return stiffness <= bound ? 1.0 : bound / stiffness;
}

/// What its maker promises, N/m.
double promise_of(const StiffnessLimits& limits) noexcept {
  return limits.stiffness_max.value_or(std::numeric_limits<double>::infinity());
}

/// Largest translational stiffness, N/m.
double translational_bound(const StiffnessLimits& limits, double lag_s) noexcept {
  const auto by_damping = [&](double damping) {
    return kStiffnessShare * (damping + limits.coupling_damping) / lag_s;
  };
  const double promise = promise_of(limits);
  if (limits.damping_guessed) return unknown_bound(limits);
  if (limits.damping > 0.0) return std::min(by_damping(limits.damping), promise);
  if (!limits.stiffness_max) return by_damping(kMinDamping);
  return std::max(kStiffnessShare * promise, std::min(by_damping(0.0), promise));
}

}  // namespace

double unknown_bound(const StiffnessLimits& limits) noexcept {
  const double lag_s = std::max(limits.period_s, limits.report_interval_s) / 2.0 + limits.delay_s;
  const double by_lag = kUnknownStiffness * kUnknownLag_s / lag_s;
  return std::min({kUnknownStiffness, by_lag, kStiffnessShare * promise_of(limits)});
}

StiffnessGrant grant_stiffness(const DeviceStiffness& wanted,
                               const StiffnessLimits& limits) noexcept {
  StiffnessGrant grant;
  const double lag_s = limits.period_s / 2.0 + limits.delay_s;
  grant.bound = translational_bound(limits, lag_s);
  grant.rotational_bound = limits.rotational_damping > 0.0
                               ? kStiffnessShare * limits.rotational_damping / lag_s
                               : std::numeric_limits<double>::infinity();
  const double scale =
      std::min({factor(wanted.kt, grant.bound), factor(wanted.kc, grant.bound),
                factor(wanted.kv, grant.bound), factor(wanted.kr, grant.rotational_bound)});
  grant.scale = scale > kMinStiffnessScale ? scale : kMinStiffnessScale;
  return grant;
}

bool add_delay(std::int64_t delay_ns, DelayEstimator& estimator) noexcept {
  if (delay_ns < 0) return false;
  // Insertion into the few longest, longest first.
  for (std::int64_t& place : estimator.longest_ns) {
    if (delay_ns > place) std::swap(delay_ns, place);
  }
  if (++estimator.count < kDelaySamples) return false;
  const std::int64_t measured_ns = estimator.longest_ns.back();
  estimator.longest_ns = {};
  estimator.count = 0;
  if (measured_ns <= estimator.estimate_ns) return false;
  estimator.estimate_ns = measured_ns;
  return true;
}

double delay_of(const DelayEstimator& estimator, double declared_s, bool time_is_virtual) noexcept {
  if (time_is_virtual || estimator.estimate_ns < 0) return declared_s;
  return static_cast<double>(estimator.estimate_ns) * 1e-9;
}

}  // namespace hapticd
