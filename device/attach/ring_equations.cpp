// See ring_equations.h.
#include "device/attach/ring_equations.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/math/elementary.h"
#include "core/tick/measuring_plan.h"

namespace hapticd {
namespace {

/// Share of a ring at whose mean it comes to rest.
constexpr double kRestShare = 0.2;
/// The first way ends at this share of where it began.
constexpr double kWayEnd = 0.37;
/// A window lasts so many times as long as the first way takes, about three quarters of a period;
/// and this share of the ring at most.
constexpr double kWindowWays = 3.0;
constexpr double kWindowShare = 0.6;
/// From window to window, as a share of one.
constexpr std::size_t kWindowSteps = 8;
/// Samples of a window at least.
constexpr std::size_t kMinWindow = 8;
/// The direction is taken over this share of a way.
constexpr std::size_t kDirectionShare = 8;
/// Slower than this share of the speed of the first way the handle counts as still.
constexpr double kStillShare = 0.05;
/// Of a window, it must move for this share. Larger: nothing is left of rings that die out;
/// smaller: friction that only holds still is taken for friction that brakes.
constexpr double kMovingShare = 0.8;

/// A window sin^4 of some length: it and its slope vanish at both ends.
struct Window {
  double value = 0.0;
  double slope = 0.0;      ///< 1/s
  double curvature = 0.0;  ///< 1/s^2
};

/// `u` s after the start of one that lasts `length` s.
Window window_at(double u, double length) {
  const double a = kPi / length;
  const double sine = std::sin(a * u);
  const double s2 = sine * sine;
  return {s2 * s2, 4.0 * a * s2 * sine * std::cos(a * u),
          4.0 * a * a * (3.0 * s2 * (1.0 - s2) - s2 * s2)};
}

/// How a ring looks at first sight.
struct Look {
  double amplitude = 0.0;  ///< m
  std::size_t way = 0;     ///< samples of the first way
  std::size_t window = 0;  ///< samples of a window
};

std::optional<Look> look_at(std::span<const RingSample> ring) {
  const double free_s = kPullRamp_s + kPullHold_s - 1e-9;
  const auto let_go = std::find_if(ring.begin(), ring.end(), [&](const RingSample& sample) {
    return sample.t_s - ring.front().t_s >= free_s;
  });
  const std::span<const RingSample> samples(let_go, ring.end());
  if (samples.size() < 2 * kMinWindow) return std::nullopt;
  const auto last = static_cast<std::size_t>(kRestShare * static_cast<double>(samples.size()));
  double rest = 0.0;
  for (const RingSample& sample : samples.last(last)) rest += sample.x / static_cast<double>(last);
  const double start = samples.front().x - rest;
  if (start == 0.0) return std::nullopt;
  Look look{std::abs(start)};
  while (look.way + 1 < samples.size() && (samples[look.way].x - rest) / start > kWayEnd)
    ++look.way;
  look.window =
      static_cast<std::size_t>(std::min(kWindowWays * static_cast<double>(look.way),
                                        kWindowShare * static_cast<double>(samples.size())));
  if (look.window < kMinWindow) return std::nullopt;
  return look;
}

/// Where it goes at a sample.
struct Direction {
  double sign = 0.0;
  bool moves = false;  ///< fast enough that the sign is sure
};

std::vector<Direction> directions_of(std::span<const RingSample> ring, const Look& look) {
  const std::size_t half = std::max<std::size_t>(1, look.way / kDirectionShare);
  const double still = kStillShare * look.amplitude * 2.0 * static_cast<double>(half) /
                       static_cast<double>(look.way);
  std::vector<Direction> directions;
  directions.reserve(ring.size());
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const double ahead = ring[std::min(i + half, ring.size() - 1)].x;
    const double behind = ring[i < half ? 0 : i - half].x;
    const double sign = ahead > behind ? 1.0 : (ahead < behind ? -1.0 : 0.0);
    directions.push_back({sign, std::abs(ahead - behind) > still});
  }
  return directions;
}

/// A stretch of a ring.
struct Stretch {
  std::span<const RingSample> ring;
  std::span<const Direction> directions;
  std::size_t first = 0;
  std::size_t size = 0;
  double x0 = 0.0;
};

/// Its equation; none where it lies still.
std::optional<RingEquation> equation_of(const Stretch& stretch) {
  const std::span<const RingSample> all = stretch.ring;
  const double begin_s = all[stretch.first].t_s;
  const double length = all[stretch.first + stretch.size].t_s - begin_s;
  Window window = window_at(0.0, length);
  RingEquation equation;
  RingVector& row = equation.row;
  double moving = 0.0;
  double whole = 0.0;
  for (std::size_t i = stretch.first; i < stretch.first + stretch.size; ++i) {
    // The force of a tick is held until the next one; at both ends the window is 0.
    const double u = all[i].t_s - begin_s;
    const double hold_s = all[i + 1].t_s - all[i].t_s;
    const Window next = window_at(u + hold_s, length);
    equation.force += 0.5 * (window.value + next.value) * all[i].f * hold_s;
    row[kDelay] -= all[i].f * (next.value - window.value);
    const double share_s = 0.5 * (all[i + 1].t_s - all[i == stretch.first ? i : i - 1].t_s);
    const double x = all[i].x - stretch.x0;
    const double weight = share_s * window.value;
    row[kMass] += share_s * window.curvature * x;
    row[kDamping] -= share_s * window.slope * x;
    row[kFriction] += weight * stretch.directions[i].sign;
    row[kOffset] -= weight;
    row[kHold] += weight * x;
    window = next;
    moving += stretch.directions[i].moves ? weight : 0.0;
    whole += weight;
  }
  return moving >= kMovingShare * whole ? std::optional(equation) : std::nullopt;
}

}  // namespace

RingEquations equations_of(std::span<const RingSample> ring, double x0) {
  RingEquations equations;
  const std::optional<Look> look = look_at(ring);
  if (!look) return equations;
  const std::vector<Direction> directions = directions_of(ring, *look);
  const std::size_t step = std::max<std::size_t>(1, look->window / kWindowSteps);
  equations.overlap = (look->window + step - 1) / step;
  equations.all.reserve(ring.size() / step + 1);
  for (std::size_t first = 0; first + look->window < ring.size(); first += step) {
    const auto equation = equation_of({ring, directions, first, look->window, x0});
    if (equation) equations.all.push_back(*equation);
  }
  return equations;
}

}  // namespace hapticd
