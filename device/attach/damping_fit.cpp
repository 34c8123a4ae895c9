// See damping_fit.h.
#include "device/attach/damping_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "core/math/vector.h"
#include "core/tick/measuring_plan.h"

namespace hapticd {
namespace {

constexpr double kPi = 3.14159265358979323846;
/// A ring counts until it stays within this share of where it began. Smaller: of friction only the
/// stick is left.
constexpr double kRingEnd = 0.1;
/// Share of a ring at whose mean it comes to rest.
constexpr double kRestShare = 0.2;
/// A window lasts so many times as long as the first way through the middle takes, about three
/// quarters of a period; and this share of the ring at most.
constexpr double kWindowWays = 3.0;
constexpr double kWindowShare = 0.6;
/// From window to window, as a share of one.
constexpr std::size_t kWindowSteps = 8;
/// Samples of a window, and windows of a ring, at least.
constexpr std::size_t kMinWindow = 8;
constexpr int kMinRows = 4;
/// What the equations leave unexplained, at most, as a share of the forces.
constexpr double kMaxResidual = 0.05;
/// Stiffness that is not the spring's, as a share of it. More: something holds the handle; further
/// below 0: the spring is not felt as it was written.
constexpr double kMaxHold = 0.03;
constexpr double kMinHold = -0.1;
/// Standard errors that a bound is away, a share of the damping for what the model leaves out, and
/// no less than this, N s/m.
constexpr double kSigmas = 3.0;
constexpr double kModelShare = 0.05;
constexpr double kModelError = 5e-3;
/// What a delay may hide of the damping, as a multiple of what the spring's stiffness makes of it.
constexpr double kDelayShare = 1.5;
/// Less cannot be told from none, N s/m.
constexpr double kMinLower = 0.01;

/// m, b, c, F_0, k_h.
constexpr int kUnknowns = 5;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;

/// Equations, summed up for least squares.
struct Equations {
  Normal N = Normal::Zero();
  Unknowns g = Unknowns::Zero();
  double square = 0.0;
  int rows = 0;

  void add(const Unknowns& row, double value) {
    N += row * row.transpose();
    g += row * value;
    square += value * value;
    ++rows;
  }
  Equations& operator+=(const Equations& other) {
    N += other.N;
    g += other.g;
    square += other.square;
    rows += other.rows;
    return *this;
  }
};

struct Solution {
  Unknowns p;
  Unknowns error;         ///< standard errors
  double residual = 0.0;  ///< share of the forces that is not explained
};

std::optional<Solution> solve(const Equations& equations) {
  const Unknowns scale = equations.N.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (!(scale.minCoeff() > 0.0) || equations.rows <= kUnknowns) return std::nullopt;
  const Unknowns inverse = scale.cwiseInverse();
  const Normal N = inverse.asDiagonal() * equations.N * inverse.asDiagonal();
  const Eigen::FullPivLU<Normal> factor(N);
  if (!factor.isInvertible()) return std::nullopt;
  const Unknowns g = inverse.cwiseProduct(equations.g);
  const Unknowns p = factor.solve(g);
  const double left = std::max(0.0, equations.square - p.dot(g));
  const double variance = left / (equations.rows - kUnknowns);
  const Unknowns spread = factor.inverse().diagonal().cwiseMax(0.0) * variance;
  Solution solution{inverse.cwiseProduct(p), inverse.cwiseProduct(spread.cwiseSqrt()),
                    std::sqrt(left / equations.square)};
  if (!solution.p.allFinite() || !solution.error.allFinite()) return std::nullopt;
  return solution;
}

/// A window sin^4 of a ring: it and its slope vanish at both ends.
struct Window {
  double length = 0.0;  ///< s

  [[nodiscard]] double value(double u) const { return std::pow(std::sin(kPi * u / length), 4); }
  [[nodiscard]] double slope(double u) const {
    const double a = kPi * u / length;
    return 4.0 * kPi / length * std::pow(std::sin(a), 3) * std::cos(a);
  }
  [[nodiscard]] double curvature(double u) const {
    const double s2 = std::pow(std::sin(kPi * u / length), 2);
    return 4.0 * std::pow(kPi / length, 2) * (3.0 * s2 * (1.0 - s2) - s2 * s2);
  }
};

/// A ring, as it was let go, and what it shows at first sight.
struct Ring {
  std::span<const RingSample> samples;
  double rest = 0.0;    ///< where it ends, m
  std::size_t way = 0;  ///< samples from the start to the middle
  std::size_t end = 0;  ///< from this sample on it hardly moves
};

std::optional<Ring> look_at(std::span<const RingSample> samples) {
  if (samples.size() < 2 * kMinWindow) return std::nullopt;
  Ring ring{samples};
  const auto last = static_cast<std::size_t>(kRestShare * static_cast<double>(samples.size()));
  for (const RingSample& sample : samples.last(last)) ring.rest += sample.x;
  ring.rest /= static_cast<double>(last);
  const double start = samples.front().x - ring.rest;
  if (start == 0.0) return std::nullopt;
  // 1 at the start, 0 at the end.
  const auto part = [&](std::size_t i) { return (samples[i].x - ring.rest) / start; };
  while (ring.way + 1 < samples.size() && part(ring.way) > 0.37) ++ring.way;
  ring.end = samples.size() - 1;
  while (ring.end > 1 && std::abs(part(ring.end - 1)) <= kRingEnd) --ring.end;
  return ring;
}

/// Sign of the velocity at sample `i`, from `half` samples before and behind it.
double direction_at(std::span<const RingSample> samples, std::size_t i, std::size_t half) {
  const double ahead = samples[std::min(i + half, samples.size() - 1)].x;
  const double behind = samples[i < half ? 0 : i - half].x;
  return ahead > behind ? 1.0 : (ahead < behind ? -1.0 : 0.0);
}

/// The equations of one ring; none where it was too short.
Equations equations_of(const Ring& ring) {
  Equations equations;
  const auto way = static_cast<double>(ring.way);
  const auto size = static_cast<std::size_t>(
      std::min(kWindowWays * way, kWindowShare * static_cast<double>(ring.end)));
  if (size < kMinWindow) return equations;
  const std::size_t half = std::max<std::size_t>(1, ring.way / 8);
  const std::span<const RingSample> all = ring.samples;
  for (std::size_t a = 0; a + size < ring.end; a += std::max<std::size_t>(1, size / kWindowSteps)) {
    const Window window{all[a + size].t_s - all[a].t_s};
    Unknowns row = Unknowns::Zero();
    double force = 0.0;
    for (std::size_t i = a; i < a + size; ++i) {
      // The force of a tick is held until the next one; at both ends the window is 0.
      const double u = all[i].t_s - all[a].t_s;
      const double hold_s = all[i + 1].t_s - all[i].t_s;
      force += window.value(u + 0.5 * hold_s) * all[i].f * hold_s;
      const double share_s = 0.5 * (all[i + 1].t_s - all[i == a ? a : i - 1].t_s);
      const double x = all[i].x - ring.rest;
      row += share_s * Unknowns(window.curvature(u) * x, -window.slope(u) * x,
                                window.value(u) * direction_at(all, i, half), -window.value(u),
                                window.value(u) * x);
    }
    equations.add(row, force);
  }
  return equations;
}

/// Samples of ring `k` since it was let go.
std::span<const RingSample> free_part(std::span<const RingSample> samples, int k) {
  const auto at = [&](double t_s) {
    return std::lower_bound(samples.begin(), samples.end(), t_s,
                            [](const RingSample& sample, double t) { return sample.t_s < t; });
  };
  const double begin_s = k * kRing_s + kPullRamp_s + kPullHold_s;
  // A tick less at the end: sums of durations round.
  const auto first = at(begin_s);
  const auto last = at((k + 1) * kRing_s - 2e-3);
  return {first, first < last ? last : first};
}

/// The spring that was felt in a ring, N/m.
double stiffness_of(const Ring& ring) {
  double xx = 0.0;
  double xf = 0.0;
  double mean_f = 0.0;
  double mean_x = 0.0;
  const auto count = static_cast<double>(ring.samples.size());
  for (const RingSample& sample : ring.samples) {
    mean_f += sample.f / count;
    mean_x += sample.x / count;
  }
  for (const RingSample& sample : ring.samples) {
    xx += (sample.x - mean_x) * (sample.x - mean_x);
    xf -= (sample.x - mean_x) * (sample.f - mean_f);
  }
  return xx > 0.0 ? xf / xx : 0.0;
}

/// The damping of each half of the rings alone, lowest and highest; none: they do not tell it.
std::optional<std::pair<double, double>> spread_of(const std::array<Equations, kRings>& rings) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  // To either side, and crosswise: both stiffnesses are in each.
  for (const auto& [a, b] : {std::pair{0, 1}, {2, 3}, {0, 3}, {1, 2}}) {
    Equations both = rings[static_cast<std::size_t>(a)];
    both += rings[static_cast<std::size_t>(b)];
    const std::optional<Solution> part = solve(both);
    if (!part) return std::nullopt;
    low = std::min(low, part->p[1]);
    high = std::max(high, part->p[1]);
  }
  return std::pair{low, high};
}

}  // namespace

DampingFit fit_damping(std::span<const RingSample> samples, double delay_s) {
  std::array<Equations, kRings> rings;
  Equations all;
  double stiffness = 0.0;
  for (int k = 0; k < kRings; ++k) {
    const std::optional<Ring> ring = look_at(free_part(samples, k));
    if (!ring) return {RingVerdict::kNoRing, {}};
    Equations& equations = rings[static_cast<std::size_t>(k)];
    equations = equations_of(*ring);
    if (equations.rows < kMinRows) return {RingVerdict::kNoRing, {}};
    all += equations;
    if (k == 0) stiffness = stiffness_of(*ring);
  }
  const std::optional<Solution> whole = solve(all);
  const auto spread = spread_of(rings);
  if (!whole || !spread) return {RingVerdict::kNoRing, {}};
  const auto& [mass, damping, friction, offset, hold] =
      std::tie(whole->p[0], whole->p[1], whole->p[2], whole->p[3], whole->p[4]);
  if (hold + 2.0 * whole->error[4] > kMaxHold * stiffness) return {RingVerdict::kHeld, {}};
  if (hold - 2.0 * whole->error[4] < kMinHold * stiffness || whole->residual > kMaxResidual ||
      !(mass > 0.0)) {
    return {RingVerdict::kUnclear, {}};
  }
  const double margin = kSigmas * whole->error[1] + kModelShare * std::abs(damping) + kModelError;
  const double hidden = kDelayShare * stiffness * delay_s;
  const DampingBounds bounds{std::min(damping, spread->first) - margin,
                             std::max(damping, spread->second) + margin + hidden, mass};
  if (bounds.lower < kMinLower) return {RingVerdict::kTooLittle, {}};
  return {RingVerdict::kMeasured, bounds};
}

}  // namespace hapticd
