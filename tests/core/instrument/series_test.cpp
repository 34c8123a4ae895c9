// A string in series with a spring: the law of one string under a finger, from mid-span to its
// ends, where the spring alone bounds the force.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/instrument/deflection.h"
#include "tests/core/instrument/strings.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

double log_uniform(SplitMix64& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

/// In [0, 1]: anywhere, within 1e-300 of A, within 1e-16 of B, on an end.
double random_place(SplitMix64& random) {
  switch (random.below(4)) {
    case 0:
      return random.uniform();
    case 1:
      return log_uniform(random, 1e-300, 0.5);
    case 2:
      return 1.0 - log_uniform(random, 1e-16, 0.5);
    default:
      return random.chance(0.5) ? 0.0 : 1.0;
  }
}

/// Any string whose parameters are in their ranges.
StringConstants random_string(SplitMix64& random) {
  const double tension = random.chance(0.1) ? 0.0 : log_uniform(random, 1e-3, 1e6);
  const double modulus = random.chance(0.1) ? 0.0 : log_uniform(random, 1.0, 1e13);
  const double radius = log_uniform(random, 1e-9, 1.0);
  return make_string(log_uniform(random, 1e-6, 1e7), tension, modulus, radius);
}

/// Anything, and in a third of the cases close to `yield`, where a string next to an end begins to
/// give way.
double random_displacement(SplitMix64& random, double yield) {
  if (yield == 0.0 || random.chance(0.7)) return log_uniform(random, 1e-12, 100.0);
  const double share = log_uniform(random, 1e-17, 1.0);
  return yield * (1.0 + (random.chance(0.5) ? share : -0.999 * share));
}

TEST_CASE("for small displacements it is two springs in series") {
  const StringConstants string = make_string(1.1, 30.0, 0.0, 0.34e-3);
  for (const double lambda : {0.01, 0.1, 0.5, 0.8}) {
    for (const double kc : {0.1, 100.0, 1e3, 1e6}) {
      const double k0 = 30.0 / (1.1 * lambda * (1.0 - lambda));
      const SeriesDeflection at = deflect_in_series(string, lambda, 1e-10, kc);
      CHECK(at.force == within(1e-10 / (1.0 / kc + 1.0 / k0), 1e-13));
      CHECK(at.delta == within(1e-10 * kc / (kc + k0), 1e-13));
    }
  }
}

TEST_CASE("a displacement of less than 1e-80 m counts as none") {
  const StringConstants string = make_string(1.1, 30.0, 0.0, 0.34e-3);
  CHECK(deflect_in_series(string, 0.5, 0.99e-80, 1000.0).force == 0.0);
  CHECK(deflect_in_series(string, 0.5, 0.99e-80, 1000.0).delta == 0.0);
  const double force = 1.01e-80 / (1.0 / 1000.0 + 1.1 / 120.0);
  CHECK(relative_error(deflect_in_series(string, 0.5, 1.01e-80, 1000.0).force,
                       static_cast<long double>(force)) < 1e-14L);
}

TEST_CASE("a displacement made of a deflection and its force is taken apart again") {
  SplitMix64 random(1);
  const std::int64_t trials = scaled(200'000);
  for (std::int64_t i = 0; i < trials; ++i) {
    const StringConstants string =
        make_string(random.uniform(0.1, 2.0), random.uniform(0.1, 1e3), random.uniform(1e8, 1e12),
                    random.uniform(0.0, 1e-3));
    const double lambda = random.uniform(1e-3, 0.999);
    const double kc = log_uniform(random, 0.1, 1e6);
    const double delta = log_uniform(random, 1e-3, 0.05);
    const long double force = BentString(string, lambda, static_cast<long double>(delta)).back();
    const auto displacement =
        static_cast<double>(static_cast<long double>(delta) + force / static_cast<long double>(kc));
    const SeriesDeflection at = deflect_in_series(string, lambda, displacement, kc);
    CHECK(std::fabs(at.delta - delta) <= 1e-12 * displacement);
    CHECK(relative_error(at.force, force) <= 1e-11L);
  }
}

TEST_CASE("both springs carry the same force, and neither more than it could alone") {
  SplitMix64 random(2);
  const std::int64_t trials = scaled(1'000'000);
  for (std::int64_t i = 0; i < trials; ++i) {
    const StringConstants string = random_string(random);
    const double lambda = random_place(random);
    const double kc = log_uniform(random, 1e-3, 1e9);
    const double displacement = random_displacement(random, string.tension / kc);
    const SeriesDeflection at = deflect_in_series(string, lambda, displacement, kc);
    const bool ordered = at.delta >= 0.0 && at.delta <= displacement && at.force >= 0.0 &&
                         at.force <= kc * displacement;
    CHECK(ordered);
    CHECK(at.force <= deflection_force(string, lambda, displacement) * (1.0 + 1e-14));
    if (at.delta == 0.0) {
      CHECK(at.force <= string.tension * (1.0 + 1e-14));
      continue;
    }
    // Each law only where the subtraction or the steepness of the other leaves it digits.
    const double of_spring = kc * (displacement - at.delta);
    CHECK(std::fabs(at.force - of_spring) <= 1e-14 * kc * displacement);
    const Deflection bent = deflect(string, lambda, at.delta);
    CHECK(std::fabs(at.force - bent.force) <=
          1e-14 * (bent.force + bent.slope * std::max(displacement, at.delta)));
  }
}

TEST_CASE("on an end the spring alone decides up to the tension, and there is no jump beyond") {
  const StringConstants string = guqin_string();
  const double kc = 1000.0;
  const double yield = string.tension / kc;
  for (const double lambda : {0.0, 1.0}) {
    for (const double share : {1e-9, 0.1, 0.999, 1.0}) {
      const SeriesDeflection at = deflect_in_series(string, lambda, share * yield, kc);
      CHECK(at.delta == 0.0);
      CHECK(at.force == kc * (share * yield));
    }
    const SeriesDeflection beyond = deflect_in_series(string, lambda, yield + 1e-9, kc);
    CHECK(beyond.delta > 0.0);
    CHECK(beyond.delta < 1e-9);
    CHECK(beyond.force > string.tension);
    CHECK(beyond.force < string.tension + kc * 1e-9);
  }
}

TEST_CASE("the force is continuous in lambda up to and on the ends") {
  const StringConstants string = guqin_string();
  for (const double displacement : {1e-9, 1e-3, 0.02, 0.03, 0.0300001, 0.05}) {
    const double on_end = deflect_in_series(string, 0.0, displacement, 1000.0).force;
    double before = on_end;
    for (double lambda = 1e-300; lambda < 0.5; lambda *= 1.1) {
      const double force = deflect_in_series(string, lambda, displacement, 1000.0).force;
      CHECK(std::fabs(force - before) <= 0.05 * on_end);
      CHECK(force <= on_end * (1.0 + 1e-9));
      before = force;
    }
    const double nearby = deflect_in_series(string, 1e-12, displacement, 1000.0).force;
    CHECK(nearby == within(on_end, 1e-6));
  }
}

TEST_CASE("the force grows with the displacement") {
  SplitMix64 random(3);
  const std::int64_t trials = scaled(100'000);
  for (std::int64_t i = 0; i < trials; ++i) {
    const StringConstants string = random_string(random);
    const double lambda = random_place(random);
    const double kc = log_uniform(random, 1e-3, 1e9);
    const double displacement = log_uniform(random, 1e-9, 1.0);
    const double force = deflect_in_series(string, lambda, displacement, kc).force;
    const double more = deflect_in_series(string, lambda, 1.001 * displacement, kc).force;
    CHECK(more >= force * (1.0 - 1e-14));
  }
}

TEST_CASE("a slack string takes all of the displacement until it stretches") {
  const StringConstants limp = make_string(1.1, 0.0, 0.0, 0.34e-3);
  for (const double lambda : {0.0, 0.3, 1.0}) {
    const SeriesDeflection at = deflect_in_series(limp, lambda, 0.01, 1000.0);
    CHECK(at.delta == 0.01);
    CHECK(at.force == 0.0);
  }
  // T 0 at mid-span, delta << L: F = E A (2 delta / L)^3.
  const StringConstants slack = make_string(1.1, 0.0, 1.9e11, 0.34e-3);
  const SeriesDeflection at = deflect_in_series(slack, 0.5, 1e-6, 1000.0);
  const double cube = std::pow(2.0 * 1e-6 / 1.1, 3.0);
  CHECK(at.force == within(slack.axial_stiffness * cube, 1e-6));
}

TEST_CASE("a string without length is a sphere that does not yield") {
  const StringConstants sphere = make_string(0.0, 30.0, 1.9e11, 0.34e-3);
  for (const double displacement : {0.01, 0.1}) {
    const SeriesDeflection at = deflect_in_series(sphere, 0.0, displacement, 1000.0);
    CHECK(at.delta == 0.0);
    CHECK(at.force == 1000.0 * displacement);
  }
}

}  // namespace
}  // namespace hapticd::test
