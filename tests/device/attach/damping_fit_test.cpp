// What is told of the damping of handles that ring in a simulation. Truth: the handles' own numbers
// (tests/support/ringing_handle.h), under a spring that this test works out for itself.
#include "device/attach/damping_fit.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "core/tick/measuring_plan.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/ringing_handle.h"

namespace hapticd::test {
namespace {

constexpr int kHandles = 300;

/// How it is measured.
struct Bench {
  double rate = 1000.0;      ///< Hz
  double stiffness = 200.0;  ///< N/m
  double pull = 0.5;         ///< N
  double delay_s = 0.0;      ///< longest that is told
};

/// The samples of a whole measuring.
std::vector<RingSample> samples_of(const HandleTruth& truth, const Bench& bench) {
  RingingHandle handle(truth);
  std::vector<RingSample> samples;
  const double tick_s = 1.0 / bench.rate;
  for (double t_s = 0.0; t_s < kMeasuring_s; t_s += tick_s) {
    const int ring = static_cast<int>(t_s / kRing_s);
    const double since_s = t_s - ring * kRing_s;
    const double k = bench.stiffness * (ring % 2 == 0 ? 1.0 : 0.5);
    const double x = handle.position();
    double f = -k * x;
    if (since_s < 0.5) {
      f += (ring < 2 ? 1.0 : -1.0) * std::min(bench.pull, k * kMaxPull) *
           std::min(1.0, since_s / 0.2);
    }
    samples.push_back({t_s, x, f});
    handle.advance(f, tick_s);
  }
  return samples;
}

DampingFit fit_of(const HandleTruth& truth, const Bench& bench) {
  return fit_damping(samples_of(truth, bench), bench.delay_s);
}

/// A loop with such a device, as hapticd sets it up; the delay is known or not.
Bench any_bench(SplitMix64& random, const HandleTruth& truth) {
  Bench bench;
  bench.rate = 500.0 * std::pow(8.0, random.uniform());
  const double tick_s = 1.0 / bench.rate;
  const double known_s = random.chance(0.5) ? truth.delay * tick_s : 0.0;
  bench.stiffness = std::min(200.0, 0.1 / (0.5 * tick_s + known_s));
  bench.pull = std::min(random.chance(0.5) ? 0.24 : 2.0, 0.4e-6 / (tick_s * tick_s));
  bench.delay_s = known_s + 3.0 * tick_s;
  return bench;
}

}  // namespace

TEST_CASE("the damping of a handle that nobody touches lies between the bounds told") {
  SplitMix64 random(fresh_seed());
  int measured = 0;
  int clear = 0;
  for (int k = 0; k < kHandles; ++k) {
    const HandleTruth truth = any_handle(random, false);
    const Bench bench = any_bench(random, truth);
    CAPTURE(k);
    CAPTURE(truth.mass);
    CAPTURE(truth.damping);
    CAPTURE(truth.friction);
    CAPTURE(truth.step);
    CAPTURE(truth.delay);
    CAPTURE(bench.rate);
    CAPTURE(bench.stiffness);
    const DampingFit fit = fit_of(truth, bench);
    clear += truth.damping > 0.3 && truth.friction == 0.0 ? 1 : 0;
    if (fit.verdict != RingVerdict::kMeasured) continue;
    measured += truth.damping > 0.3 && truth.friction == 0.0 ? 1 : 0;
    CHECK(fit.bounds.lower <= truth.damping);
    CHECK(fit.bounds.upper >= truth.damping);
    CHECK(fit.bounds.lower > 0.0);
    if (truth.damping * truth.damping < 0.1 * truth.mass * bench.stiffness) {
      CHECK(std::abs(fit.bounds.mass - truth.mass) < 0.2 * truth.mass);
    }
  }
  // Most of those that ring without friction are measured.
  CHECK(2 * measured > clear);
}

TEST_CASE("a hand that holds on is never taken for damping of the handle") {
  SplitMix64 random(fresh_seed());
  for (int k = 0; k < kHandles; ++k) {
    const HandleTruth truth = any_handle(random, true);
    const Bench bench = any_bench(random, truth);
    CAPTURE(k);
    CAPTURE(truth.mass);
    CAPTURE(truth.damping);
    CAPTURE(truth.hand_mass);
    CAPTURE(truth.hand_damping);
    CAPTURE(truth.hand_stiffness);
    CAPTURE(bench.rate);
    const DampingFit fit = fit_of(truth, bench);
    if (fit.verdict == RingVerdict::kMeasured) CHECK(fit.bounds.lower <= truth.damping);
  }
  HandleTruth usual;
  usual.hand_mass = 0.1;
  usual.hand_damping = 3.0;
  usual.hand_stiffness = 150.0;
  CHECK(fit_of(usual, {}).verdict == RingVerdict::kHeld);
}

TEST_CASE("dry friction, by which a ring ends in a straight line, is not counted as damping") {
  SplitMix64 random(fresh_seed());
  for (int k = 0; k < 100; ++k) {
    HandleTruth truth = any_handle(random, false);
    truth.damping = 1e-3;
    truth.friction = 1e-3 + 0.05 * random.uniform();
    const DampingFit fit = fit_of(truth, any_bench(random, truth));
    CAPTURE(truth.mass);
    CAPTURE(truth.friction);
    CHECK(fit.verdict != RingVerdict::kMeasured);
  }
}

TEST_CASE("a usual handle is told within a fifth, and its mass") {
  HandleTruth truth;
  truth.step = 2e-5;
  const DampingFit fit = fit_of(truth, {});
  REQUIRE(fit.verdict == RingVerdict::kMeasured);
  CHECK(fit.bounds.lower > 0.8);
  CHECK(fit.bounds.upper < 1.2);
  CHECK(std::abs(fit.bounds.mass - 0.15) < 2e-3);
}

TEST_CASE("a handle that does not move, or of which there are no samples, has not rung") {
  std::vector<RingSample> still;
  for (double t_s = 0.0; t_s < kMeasuring_s; t_s += 1e-3) still.push_back({t_s, 0.01, 0.0});
  CHECK(fit_damping(still, 0.0).verdict == RingVerdict::kNoRing);
  CHECK(fit_damping({}, 0.0).verdict == RingVerdict::kNoRing);
  still.resize(3000);
  CHECK(fit_damping(still, 0.0).verdict == RingVerdict::kNoRing);
}

TEST_CASE("a handle without damping, and one that swings up, are not told to have any") {
  HandleTruth truth;
  truth.damping = 1e-4;
  CHECK(fit_of(truth, {}).verdict != RingVerdict::kMeasured);
  truth.delay = 2;
  CHECK(fit_of(truth, {}).verdict != RingVerdict::kMeasured);
}

}  // namespace hapticd::test
