// A hand's damping is never told for the device's, whatever a passive hand does: random ones, and
// the worst that an adversary climbs to. Truth: a simulation of its own
// (tests/support/held_handle.h) under a spring that this test works out for itself.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/tick/measuring_plan.h"
#include "device/attach/damping_fit.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/held_handle.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// A hand is noticed from this stiffness on, N/m; a softer one damps for so long at most, s.
constexpr double kNoticed = 10.0;
constexpr double kHandLasts_s = 0.1;

/// Who is measured, and how.
struct Measured {
  HeldTruth truth;
  double rate = 1000.0;        ///< Hz
  bool delay_is_told = false;  ///< by the profile
  double peak = 4.0;           ///< force limit, N
};

/// Numbers in [0, 1], of which one Measured is made.
using Place = std::array<double, 24>;

double scaled_up(double low, double high, double share) {
  return low * std::pow(high / low, share);
}

/// None in so many cases.
double or_none(double none, double low, double high, double share) {
  return share < none ? 0.0 : scaled_up(low, high, (share - none) / (1.0 - none));
}

/// No hand damps more than it can, as it stands in damping_fit.h.
double hand_damping(const HeldTruth& truth, double share, double ratio) {
  const double most = std::min(10.0, kHandLasts_s * truth.hand_stiffness);
  double stiffness = truth.hand_stiffness;
  if (truth.kind == HandKind::kSoft) {
    stiffness *= truth.grip_stiffness / (stiffness + truth.grip_stiffness);
  }
  const bool may_be_any = truth.kind != HandKind::kFading && stiffness >= kNoticed;
  return ratio < 0.5 || !may_be_any ? most * share : 10.0 * share;
}

Measured measured_at(const Place& u, HandKind kind) {
  Measured all;
  HeldTruth& truth = all.truth;
  truth.mass = scaled_up(0.03, 1.0, u[0]);
  truth.damping = scaled_up(0.03, 8.0, u[1]);
  truth.friction = or_none(0.3, 1e-3, 0.1, u[2]);
  truth.weight = 0.2 * u[3] - 0.1;
  truth.step = or_none(0.3, 1e-6, 1e-4, u[4]);
  truth.noise = or_none(0.3, 1e-7, 3e-5, u[5]);
  truth.delay = std::min(3, static_cast<int>(4.0 * u[6]));
  all.delay_is_told = u[7] < 0.5;
  all.rate = scaled_up(500.0, 4000.0, u[8]);
  all.peak = u[9] < 0.5 ? 0.3 : 4.0;
  truth.kind = kind;
  truth.hand_mass = u[10];
  truth.hand_stiffness =
      u[11] < 0.5 ? scaled_up(1.0, 500.0, 2.0 * u[11]) : 500.0 * (2.0 * u[11] - 1.0);
  truth.grip_stiffness = scaled_up(100.0, 2000.0, u[13]);
  truth.grip_damping = std::min(scaled_up(0.1, 10.0, u[14]), kHandLasts_s * truth.grip_stiffness);
  truth.hand_damping = hand_damping(truth, u[12], u[21]);
  truth.fade_s = scaled_up(0.2, 10.0, u[15]);
  truth.from_s = kMeasuring_s * u[16];
  truth.until_s = truth.from_s + scaled_up(0.05, kMeasuring_s, u[17]);
  truth.gap = u[18] < 0.3 ? 0.0 : 0.006 * u[18] - 0.003;
  truth.hand_rest = u[19] < 0.4 ? 0.0 : 0.002 * u[19] - 0.001;
  truth.seed = 1 + static_cast<std::uint64_t>(1e6 * u[20]);
  return all;
}

DampingFit fit_of(const Measured& all) {
  HeldHandle handle(all.truth);
  const double tick_s = 1.0 / all.rate;
  const double known_s = all.delay_is_told ? all.truth.delay * tick_s : 0.0;
  const double stiffness = std::min(200.0, 0.1 / (0.5 * tick_s + known_s));
  const double most = std::min(0.8 * all.peak, 0.4e-6 / (tick_s * tick_s));
  std::vector<RingSample> samples;
  samples.reserve(static_cast<std::size_t>(kMeasuring_s * all.rate) + 1);
  for (double t_s = 0.0; t_s < kMeasuring_s; t_s += tick_s) {
    const int ring = static_cast<int>(t_s / kRing_s);
    const double since_s = t_s - ring * kRing_s;
    const double k = stiffness * (ring % 2 == 0 ? 1.0 : 0.5);
    const double x = handle.position();
    double f = -k * x;
    if (since_s < 0.5) {
      const double pull = std::min({most, k * kMaxPull, std::sqrt(2.0 * k * 0.16e-3)});
      f += (ring < 2 ? pull : -pull) * std::min(1.0, since_s / 0.2);
    }
    samples.push_back({t_s, x, f});
    handle.advance(f, tick_s);
  }
  return fit_damping(samples, known_s + 3.0 * tick_s);
}

std::string told(const Measured& all) {
  const HeldTruth& t = all.truth;
  std::string text =
      "mass damping friction weight step noise delay kind hand m b k rest, grip k b, "
      "fade from until gap, rate told peak:";
  for (const double number : {t.mass,
                              t.damping,
                              t.friction,
                              t.weight,
                              t.step,
                              t.noise,
                              static_cast<double>(t.delay),
                              static_cast<double>(t.kind),
                              t.hand_mass,
                              t.hand_damping,
                              t.hand_stiffness,
                              t.hand_rest,
                              t.grip_stiffness,
                              t.grip_damping,
                              t.fade_s,
                              t.from_s,
                              t.until_s,
                              t.gap,
                              all.rate,
                              all.delay_is_told ? 1.0 : 0.0,
                              all.peak}) {
    text += " " + std::to_string(number);
  }
  return text;
}

Place any_place(SplitMix64& random) {
  Place place{};
  for (double& u : place) u = random.uniform();
  return place;
}

HandKind kind_of(std::int64_t k) {
  return static_cast<HandKind>(k % static_cast<int>(HandKind::kKinds));
}

/// Somebody who looks for the place where most is told too much.
class Adversary {
 public:
  Adversary(HandKind kind, std::uint64_t seed) : kind_(kind), random_(seed) {}

  /// Where anything is told at all of a hand that matters; false: nowhere.
  [[nodiscard]] bool begin() {
    for (int k = 0; k < 400 && !(excess_ > kNothing); ++k) {
      Place place = any_place(random_);
      // Firm hands are all noticed.
      if (k > 10) place[11] *= 0.3;
      try_at(place);
    }
    return excess_ > kNothing;
  }
  void climb(int steps) {
    double size = 0.3;
    for (int k = 0; k < steps; ++k) {
      Place place = place_;
      const auto changes = 1 + random_.below(4);
      for (std::uint64_t j = 0; j < changes; ++j) {
        double& u = place[random_.below(place.size())];
        u = random_.chance(0.2) ? random_.uniform()
                                : std::clamp(u + size * random_.uniform(-1.0, 1.0), 0.0, 1.0);
      }
      size = try_at(place) ? std::min(0.5, 1.3 * size) : std::max(5e-3, 0.97 * size);
    }
  }
  /// By how much too much is told, as a share of the damping.
  [[nodiscard]] double excess() const { return excess_; }
  [[nodiscard]] Measured where() const { return measured_at(place_, kind_); }

 private:
  static constexpr double kNothing = -9.0;

  /// Goes there if it is better.
  bool try_at(const Place& place) {
    const Measured all = measured_at(place, kind_);
    const HeldTruth& truth = all.truth;
    // A hand that does nothing has as good as let go: the margin alone would be found.
    const bool grips = kind_ == HandKind::kSoft && truth.grip_damping > truth.damping;
    const bool matters = truth.hand_damping > 0.5 * truth.damping || grips;
    if (kind_ != HandKind::kNone && !matters) return false;
    const DampingFit fit = fit_of(all);
    if (fit.verdict != RingVerdict::kMeasured) return false;
    const double excess = fit.bounds.lower / truth.damping - 1.0;
    if (!(excess > excess_)) return false;
    excess_ = excess;
    place_ = place;
    return true;
  }

  HandKind kind_;
  SplitMix64 random_;
  Place place_{};
  double excess_ = kNothing;
};

}  // namespace

TEST_CASE("of no hand that holds, touches, fades or comes and goes is its damping told") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  int measured = 0;
  double worst = -1.0;
  const std::int64_t count = scaled(6000);
  for (std::int64_t k = 0; k < count; ++k) {
    const Measured all = measured_at(any_place(random), kind_of(k));
    const DampingFit fit = fit_of(all);
    if (fit.verdict != RingVerdict::kMeasured) continue;
    ++measured;
    worst = std::max(worst, fit.bounds.lower / all.truth.damping - 1.0);
    CAPTURE(told(all));
    CHECK(fit.bounds.lower <= all.truth.damping);
  }
  MESSAGE(measured, " of ", count, " measured, at least ", -worst, " of the damping below it");
  CHECK(measured > 0);
}

TEST_CASE("an adversary that climbs for the worst hand, friction and delay finds none") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  int begun = 0;
  const std::int64_t count = scaled(60);
  for (std::int64_t k = 0; k < count; ++k) {
    Adversary adversary(kind_of(k), random.next());
    if (!adversary.begin()) continue;
    ++begun;
    adversary.climb(200);
    CAPTURE(told(adversary.where()));
    CHECK(adversary.excess() <= 0.0);
  }
  CHECK(begun > 0);
}

TEST_CASE("a firm hand is noticed, and the remedy is to let go") {
  SplitMix64 random(fresh_seed());
  const std::int64_t count = scaled(1000);
  for (std::int64_t k = 0; k < count; ++k) {
    Measured all = measured_at(any_place(random), HandKind::kFirm);
    all.truth.hand_stiffness = random.uniform(30.0, 500.0);
    all.truth.hand_damping = random.uniform(0.0, 10.0);
    CAPTURE(told(all));
    CHECK(fit_of(all).verdict != RingVerdict::kMeasured);
  }
}

TEST_CASE("a usual handle that hangs free is told at more than half of its damping") {
  SplitMix64 random(fresh_seed());
  int useful = 0;
  const auto count = static_cast<int>(scaled(1000));
  for (int k = 0; k < count; ++k) {
    Measured all;
    HeldTruth& truth = all.truth;
    truth.mass = scaled_up(0.05, 1.0, random.uniform());
    truth.damping = scaled_up(0.3, 3.0, random.uniform());
    truth.friction = or_none(0.6, 1e-3, 0.03, random.uniform());
    truth.weight = random.uniform(-0.05, 0.05);
    truth.step = or_none(0.3, 1e-6, 5e-5, random.uniform());
    truth.noise = or_none(0.7, 1e-7, 5e-6, random.uniform());
    truth.delay = static_cast<int>(random.below(2));
    all.delay_is_told = random.chance(0.5);
    all.peak = random.chance(0.5) ? 0.3 : 4.0;
    const DampingFit fit = fit_of(all);
    if (fit.verdict != RingVerdict::kMeasured) continue;
    CAPTURE(told(all));
    CHECK(fit.bounds.lower <= truth.damping);
    CHECK(fit.bounds.upper >= truth.damping);
    useful += fit.bounds.lower > 0.5 * truth.damping ? 1 : 0;
  }
  CHECK(10 * useful >= 9 * count);
}

}  // namespace hapticd::test
