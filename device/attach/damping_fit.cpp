// See damping_fit.h.
#include "device/attach/damping_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

#include "core/tick/measuring_plan.h"
#include "device/attach/ring_solution.h"

namespace hapticd {
namespace {

/// Equations of a ring at least.
constexpr std::size_t kMinRows = 4;
/// What the equations leave unexplained, at most, as a share of the forces.
constexpr double kMaxResidual = 0.05;
/// Further below 0 the stiffness of a handle is no error, N/m: the spring is not felt as written,
/// or the handle tips over, which would hide a hand.
constexpr double kMinHold = -2.0;
/// Standard errors that a bound is away, a share of the damping for what the model leaves out, and
/// no less than this, N s/m.
constexpr double kSigmas = 3.0;
constexpr double kModelShare = 0.05;
constexpr double kModelError = 5e-3;
/// Less cannot be told from none, N s/m.
constexpr double kMinLower = 0.01;

using Rings = std::array<RingEquations, kRings>;

/// Samples of ring `k`, with the pull before it.
std::span<const RingSample> ring_part(std::span<const RingSample> samples, int k) {
  const auto at = [&](double t_s) {
    return std::lower_bound(samples.begin(), samples.end(), t_s,
                            [](const RingSample& sample, double t) { return sample.t_s < t; });
  };
  // Sums of durations round, and the last tick holds its force into the next ring.
  const auto first = at(k * kRing_s - 1e-9);
  const auto last = at((k + 1) * kRing_s - 2e-3);
  return {first, first < last ? last : first};
}

/// What the rings `which` say of the damping at least: with the shortest delay that is plausible,
/// and no friction below 0.
std::optional<RingSolution> lowest_of(const Rings& rings, std::initializer_list<int> which,
                                      double longest_s) {
  std::vector<const RingEquations*> chosen;
  chosen.reserve(which.size());
  for (const int k : which) chosen.push_back(&rings[static_cast<std::size_t>(k)]);
  RingGiven given;
  const std::optional<RingSolution> free = solve(chosen, given);
  if (!free) return std::nullopt;
  // Below 0 it is error, or what dangles from the handle: its damping grows with the frequency.
  const double delay_s = free->p[kDelay];
  given[kDelay] =
      std::min(delay_s, std::clamp(delay_s - kSigmas * free->error[kDelay], 0.0, longest_s));
  std::optional<RingSolution> lowest = solve(chosen, given);
  if (!lowest || lowest->p[kFriction] >= 0.0) return lowest;
  given[kFriction] = 0.0;
  return solve(chosen, given);
}

/// Each half of the rings with both stiffnesses alone: to either side, and crosswise.
struct Halves {
  double lowest = 0.0;  ///< damping, N s/m
  double highest = 0.0;
  double hold = 0.0;  ///< k_h, highest, N/m
};

std::optional<Halves> halves_of(const Rings& rings, const RingSolution& whole, double longest_s) {
  Halves halves{whole.p[kDamping], whole.p[kDamping], whole.p[kHold]};
  for (const auto& [a, b] : {std::pair{0, 1}, {2, 3}, {0, 3}, {1, 2}}) {
    const std::optional<RingSolution> half = lowest_of(rings, {a, b}, longest_s);
    if (!half) return std::nullopt;
    halves.lowest = std::min(halves.lowest, half->p[kDamping]);
    halves.highest = std::max(halves.highest, half->p[kDamping]);
    halves.hold = std::max(halves.hold, half->p[kHold]);
  }
  return halves;
}

/// The damping if the delay is the longest, N s/m; less than `otherwise` is not told.
double highest_of(const Rings& rings, double longest_s, double otherwise) {
  std::array<const RingEquations*, kRings> all{};
  std::transform(rings.begin(), rings.end(), all.begin(), [](const auto& ring) { return &ring; });
  RingGiven given;
  given[kDelay] = longest_s;
  const std::optional<RingSolution> late = solve(all, given);
  if (!late) return otherwise;
  return std::max(otherwise, late->p[kDamping] + kSigmas * late->error[kDamping]);
}

}  // namespace

DampingFit fit_damping(std::span<const RingSample> samples, double delay_s) {
  if (samples.empty()) return {RingVerdict::kNoRing, {}};
  Rings rings;
  for (int k = 0; k < kRings; ++k) {
    RingEquations& ring = rings[static_cast<std::size_t>(k)];
    ring = equations_of(ring_part(samples, k), samples.front().x);
    if (ring.all.size() < kMinRows) return {RingVerdict::kNoRing, {}};
  }
  const std::optional<RingSolution> whole = lowest_of(rings, {0, 1, 2, 3}, delay_s);
  if (!whole) return {RingVerdict::kNoRing, {}};
  const std::optional<Halves> halves = halves_of(rings, *whole, delay_s);
  if (!halves) return {RingVerdict::kNoRing, {}};
  const double hold = halves->hold + kSigmas * whole->error[kHold];
  if (hold > kMaxHold) return {RingVerdict::kHeld, {}};
  if (hold < kMinHold || whole->residual > kMaxResidual || !(whole->p[kMass] > 0.0)) {
    return {RingVerdict::kUnclear, {}};
  }
  const double margin =
      kSigmas * whole->error[kDamping] + kModelShare * std::abs(whole->p[kDamping]) + kModelError;
  const double lower = halves->lowest - margin - kHandTime * std::max(0.0, hold);
  if (lower < kMinLower) return {RingVerdict::kTooLittle, {}};
  const double upper = highest_of(rings, delay_s, halves->highest) + margin;
  return {RingVerdict::kMeasured, {lower, upper, whole->p[kMass]}};
}

}  // namespace hapticd
