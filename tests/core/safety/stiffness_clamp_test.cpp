// Truth: the bound as published, by hand; percentiles by sorting; and a simulated handle that rings
// just above the whole bound and not at the half that is granted.
#include "core/safety/stiffness_clamp.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// Largest excursion in the last of four seconds over that in the first, of 0.15 kg with damping b
/// on a spring K sampled at T and held.
double ringing(double stiffness, double damping, double period_s) {
  constexpr double kMass = 0.15;
  double x = 1e-3;
  double v = 0.0;
  double first = 0.0;
  double last = 0.0;
  const int ticks = static_cast<int>(4.0 / period_s);
  for (int i = 0; i < ticks; ++i) {
    const double force = -stiffness * x;
    for (int k = 0; k < 50; ++k) {
      v += (force - damping * v) / kMass * period_s / 50;
      x += v * period_s / 50;
    }
    if (i < ticks / 4) first = std::max(first, std::abs(x));
    if (i > ticks * 3 / 4) last = std::max(last, std::abs(x));
  }
  return last / first;
}

}  // namespace

TEST_CASE("half of (b + B) / (T/2 + t_d) is granted") {
  StiffnessLimits limits;  // b = 1, T = 1 ms: half of 2000 N/m
  CHECK(grant_stiffness({1000, 0, 0, 0}, limits).scale == 1.0);
  CHECK(grant_stiffness({4000, 0, 0, 0}, limits).scale == doctest::Approx(0.25));
  limits.delay_s = 1e-3;
  CHECK(grant_stiffness({1000, 0, 0, 0}, limits).bound == doctest::Approx(1.0 / 3e-3));
  limits.coupling_damping = 2.0;
  CHECK(grant_stiffness({1000, 0, 0, 0}, limits).scale == 1.0);
}

TEST_CASE("a handle without a hand rings at the whole bound and is quiet at what is granted") {
  const double granted = grant_stiffness({1e6, 0, 0, 0}, {}).bound;
  CHECK(ringing(granted, 1.0, 1e-3) < 0.5);
  CHECK(ringing(2.0 * granted * 1.2, 1.0, 1e-3) > 1.0);
}

TEST_CASE("the stiffest of all couplings decides, by its own bound") {
  SplitMix64 random(41);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const DeviceStiffness wanted{random.uniform(0, 1e4), random.uniform(0, 10.0),
                                 random.uniform(0, 1e4), random.uniform(0, 1e4)};
    StiffnessLimits limits;
    limits.delay_s = random.uniform(0.0, 5e-3);
    const StiffnessGrant grant = grant_stiffness(wanted, limits);
    const double most = 0.5 / (0.5e-3 + limits.delay_s);
    const double stiffest = std::max({wanted.kt, wanted.kc, wanted.kv}) / most;
    const double turning = wanted.kr / (most * 1e-3);
    REQUIRE(grant.scale == doctest::Approx(std::min(1.0, 1.0 / std::max(stiffest, turning))));
    REQUIRE(grant.scale > 0.0);
    REQUIRE(grant.scale <= 1.0);
  }
}

TEST_CASE("the maker's promise bounds too, and alone by its half") {
  StiffnessLimits limits;
  limits.stiffness_max = 700.0;
  CHECK(grant_stiffness({1000, 0, 0, 0}, limits).bound == 700.0);
  limits.damping = 0.0;
  CHECK(grant_stiffness({1000, 0, 0, 0}, limits).bound == 350.0);
  // A little damping of the coupling is no reason for less.
  limits.coupling_damping = 1e-6;
  CHECK(grant_stiffness({1000, 0, 0, 0}, limits).bound == 350.0);
  limits.coupling_damping = 0.5;
  CHECK(grant_stiffness({1000, 0, 0, 0}, limits).bound == doctest::Approx(500.0));
  limits.coupling_damping = 5.0;
  CHECK(grant_stiffness({1000, 0, 0, 0}, limits).bound == 700.0);
  limits.coupling_damping = 0.0;
  CHECK(grant_stiffness({0, 0, 0, 0}, limits).scale == 1.0);
  limits.damping = 1.0;
  limits.rotational_damping = 0.0;
  CHECK(grant_stiffness({0, 100, 0, 0}, limits).scale == 1.0);
}

TEST_CASE("what is not stated bounds nothing: the least that is known does, and it is never 0") {
  SplitMix64 random(43);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const bool has_damping = random.chance(0.5);
    const bool has_promise = random.chance(0.5);
    StiffnessLimits limits;
    limits.damping = has_damping ? random.uniform(0.01, 10.0) : 0.0;
    limits.delay_s = random.chance(0.5) ? random.uniform(0.0, 0.01) : 0.0;
    limits.coupling_damping = random.chance(0.3) ? random.uniform(0.0, 3.0) : 0.0;
    if (has_promise) limits.stiffness_max = random.uniform(1.0, 1e5);
    const double lag = 0.5e-3 + limits.delay_s;
    const double B = limits.coupling_damping;
    const double bound = grant_stiffness({1000, 0, 0, 0}, limits).bound;
    double most = kInf;
    double least = 0.0;
    if (has_damping) {
      most = least = 0.5 * (limits.damping + B) / lag;
    } else if (!has_promise) {
      most = least = 0.5 * (0.1 + B) / lag;
    } else {
      least = 0.5 * std::max(*limits.stiffness_max, std::min(B / lag, *limits.stiffness_max));
    }
    if (has_promise) most = std::min(most, *limits.stiffness_max);
    REQUIRE(bound > 0.0);
    REQUIRE(bound <= most * (1.0 + 1e-12));
    REQUIRE(bound >= std::min(least, most) * (1.0 - 1e-12));
  }
}

TEST_CASE("where the damping is a guess an unknown device's stiffness is granted, and never 0") {
  StiffnessLimits limits;
  limits.damping_guessed = true;
  const auto bound = [&] { return grant_stiffness({1000, 0, 0, 0}, limits).bound; };
  CHECK(bound() == doctest::Approx(200.0));
  limits.report_interval_s = 10e-3;
  CHECK(bound() == doctest::Approx(20.0));
  limits.report_interval_s = 1e-3;
  limits.delay_s = 3e-3;
  CHECK(bound() == doctest::Approx(200.0 / 7.0));
  SplitMix64 random(fresh_seed());
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    // Whatever the guess is.
    limits.damping = random.uniform(0.0, 100.0);
    limits.coupling_damping = random.uniform(0.0, 3.0);
    limits.period_s = random.uniform(1e-4, 4e-3);
    limits.report_interval_s = random.uniform(1e-4, 0.1);
    limits.delay_s = random.chance(0.5) ? random.uniform(0.0, 0.1) : 0.0;
    const double lag = std::max(limits.period_s, limits.report_interval_s) / 2 + limits.delay_s;
    limits.stiffness_max.reset();
    REQUIRE(bound() == doctest::Approx(200.0 * std::min(1.0, 0.5e-3 / lag)));
    const double free = bound();
    limits.stiffness_max = random.uniform(1.0, 1e4);
    REQUIRE(bound() == doctest::Approx(std::min(free, 0.5 * *limits.stiffness_max)));
    REQUIRE(bound() > 0.0);
  }
}

TEST_CASE("stiffnesses that are no numbers get the smallest scale") {
  for (const double bad : {kInf, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(grant_stiffness({bad, 0, 0, 0}, {}).scale == kMinStiffnessScale);
    CHECK(grant_stiffness({0, bad, 0, 0}, {}).scale == kMinStiffnessScale);
    CHECK(grant_stiffness({0, 0, bad, 0}, {}).scale == kMinStiffnessScale);
    CHECK(grant_stiffness({0, 0, 0, bad}, {}).scale == kMinStiffnessScale);
  }
}

TEST_CASE("the measured delay is the third longest of 256, the largest such block so far") {
  SplitMix64 random(42);
  DelayEstimator estimator;
  std::int64_t truth = -1;
  for (int block = 0; block < 50; ++block) {
    std::vector<std::int64_t> sorted;
    for (int k = 0; k < kDelaySamples; ++k) {
      CHECK(estimator.estimate_ns == truth);
      const auto delay_ns = static_cast<std::int64_t>(random.below(3'000'000));
      sorted.push_back(delay_ns);
      const bool changed = add_delay(delay_ns, estimator);
      CHECK((!changed || k == kDelaySamples - 1));
    }
    std::sort(sorted.begin(), sorted.end());
    truth = std::max(truth, sorted[kDelaySamples - 3]);
    CHECK(estimator.estimate_ns == truth);
  }
}

TEST_CASE("the declared delay holds until measured, and always when time is virtual") {
  DelayEstimator estimator;
  CHECK(delay_of(estimator, 2e-3, false) == 2e-3);
  CHECK_FALSE(add_delay(-5, estimator));
  CHECK(estimator.count == 0);
  for (int k = 0; k < kDelaySamples; ++k) (void)add_delay(1'500'000, estimator);
  CHECK(delay_of(estimator, 2e-3, false) == doctest::Approx(1.5e-3));
  CHECK(delay_of(estimator, 2e-3, true) == 2e-3);
}

}  // namespace hapticd::test
