// What the laws of a deflected string must be whatever the numbers: limits, energy, symmetry,
// monotony, balance, and the sizes of its effects on a real string.
#include "core/instrument/deflection.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>

#include "tests/core/instrument/strings.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A string between a slack thread and a steel cable, its place and its deflection.
struct Case {
  StringConstants string;
  double lambda;
  double delta;
};

/// Long enough against delta that long double resolves its stretch to 1e-12.
Case random_case(SplitMix64& random) {
  const double radius = random.uniform(0.0, 1e-3);
  const double modulus = random.uniform(1e8, 1e12);
  const double length = random.uniform(0.1, 2.0);
  return {make_string(length, random.uniform(0.1, 1e3), modulus, radius),
          random.uniform(0.01, 0.99), random.uniform(1e-3, 0.05)};
}

TEST_CASE("a string barely deflected is a spring of stiffness k0 = T / (L lambda (1 - lambda))") {
  const StringConstants string = guqin_string();
  for (const double lambda : {0.001, 0.1, 0.25, 0.5, 0.9}) {
    const double k0 = 30.0 / (1.1 * lambda * (1.0 - lambda));
    CHECK(small_deflection_stiffness(string, lambda) == within(k0, 1e-14));
    CHECK(deflect(string, lambda, 0.0).slope == small_deflection_stiffness(string, lambda));
    CHECK(deflect(string, lambda, 0.0).secant == small_deflection_stiffness(string, lambda));
    const Deflection small = deflect(string, lambda, 1e-11);
    CHECK(small.force == within(k0 * 1e-11, 1e-12));
    CHECK(small.slope == within(k0, 1e-12));
    CHECK(small.energy == within(0.5 * k0 * 1e-22, 1e-12));
  }
}

TEST_CASE("at mid-span the force is that of two equal halves") {
  const StringConstants string = guqin_string();
  for (const double delta : {1e-4, 1e-3, 5e-3, 0.02, 0.5}) {
    const long double half = 0.55L;
    const long double side = std::hypot(half, static_cast<long double>(delta));
    const long double square = static_cast<long double>(delta) * static_cast<long double>(delta);
    const long double strain = square / (side + half) / half;
    const long double tension = 30.0L + static_cast<long double>(string.axial_stiffness) * strain;
    const long double force = 2.0L * tension * static_cast<long double>(delta) / side;
    CHECK(relative_error(deflect(string, 0.5, delta).force, force) < 1e-14L);
  }
}

/// Integral of F from 0 to delta: 8-point Gauss-Legendre on panels that halve towards 0.
long double work_of_finger(const Case& at) {
  constexpr std::array<long double, 4> kNodes{0.183434642495649804939L, 0.525532409916328985818L,
                                              0.796666477413626739592L, 0.960289856497536231684L};
  constexpr std::array<long double, 4> kWeights{0.362683783378361982965L, 0.313706645877887287338L,
                                                0.222381034453374470544L, 0.101228536290376259153L};
  const auto force = [&](long double delta) {
    return static_cast<long double>(
        deflection_force(at.string, at.lambda, static_cast<double>(delta)));
  };
  long double sum = 0.0L;
  long double top = static_cast<long double>(at.delta);
  for (int panel = 0; panel < 50; ++panel) {
    const long double half = top / 4.0L;
    const long double centre = 3.0L * half;
    for (std::size_t i = 0; i < kNodes.size(); ++i) {
      const long double offset = kNodes.at(i) * half;
      sum += kWeights.at(i) * half * (force(centre - offset) + force(centre + offset));
    }
    top /= 2.0L;
  }
  return sum;
}

TEST_CASE("the energy is the integral of the force") {
  SplitMix64 random(1);
  const std::int64_t trials = scaled(2'000);
  for (std::int64_t i = 0; i < trials; ++i) {
    const Case at = random_case(random);
    const Deflection bent = deflect(at.string, at.lambda, at.delta);
    CHECK(relative_error(bent.energy, work_of_finger(at)) < 1e-12L);
  }
}

TEST_CASE("the slope is the derivative of the force") {
  SplitMix64 random(2);
  const std::int64_t trials = scaled(20'000);
  for (std::int64_t i = 0; i < trials; ++i) {
    const Case at = random_case(random);
    const long double delta = static_cast<long double>(at.delta);
    const long double step = 1e-3L * delta;
    const auto force = [&](long double steps) {
      return BentString(at.string, at.lambda, delta + steps * step).back();
    };
    const long double derivative =
        (8.0L * (force(1.0L) - force(-1.0L)) - (force(2.0L) - force(-2.0L))) / (12.0L * step);
    CHECK(relative_error(deflect(at.string, at.lambda, at.delta).slope, derivative) < 1e-9L);
  }
}

TEST_CASE("the force on the finger is the balance of its two halves, along the axis and across") {
  SplitMix64 random(3);
  const std::int64_t trials = scaled(20'000);
  for (std::int64_t i = 0; i < trials; ++i) {
    const Case at = random_case(random);
    const BentString truth(at.string, at.lambda, static_cast<long double>(at.delta));
    const Deflection bent = deflect(at.string, at.lambda, at.delta);
    CHECK(relative_error(bent.force, truth.back()) < 1e-9L);
    if (std::fabs(at.lambda - 0.5) > 1e-3) {
      CHECK(relative_error(bent.lateral_force, truth.along()) < 1e-9L);
    }
  }
}

TEST_CASE("the lateral force points to the middle and vanishes there") {
  const StringConstants string = guqin_string();
  CHECK(deflect(string, 0.5, 0.01).lateral_force == 0.0);
  CHECK(deflect(string, 0.4999, 0.01).lateral_force > 0.0);
  CHECK(deflect(string, 0.5001, 0.01).lateral_force < 0.0);
  // On an end one half is square to the axis and the other nearly along it.
  const double along = 30.0 + string.axial_stiffness * 0.01 / 1.1;
  CHECK(deflect(string, 0.0, 0.01).lateral_force == within(along, 0.01));
  CHECK(deflect(string, 1.0, 0.01).lateral_force == within(-along, 0.01));
}

TEST_CASE("a string reversed end for end answers with the same bits") {
  SplitMix64 random(4);
  const std::int64_t trials = scaled(100'000);
  for (std::int64_t i = 0; i < trials; ++i) {
    const Case at = random_case(random);
    // 1 - lambda is exact for a multiple of 2^-20.
    const double lambda = static_cast<double>(random.below((1U << 20U) + 1U)) * 0x1p-20;
    const Deflection there = deflect(at.string, lambda, at.delta);
    const Deflection here = deflect(at.string, 1.0 - lambda, at.delta);
    CHECK(there.force == here.force);
    CHECK(there.slope == here.slope);
    CHECK(there.energy == here.energy);
    CHECK(there.axial_force == here.axial_force);
    CHECK(there.lateral_force == -here.lateral_force);
  }
}

TEST_CASE("the force grows with deflection, tension, Young's modulus and radius") {
  SplitMix64 random(5);
  const std::int64_t trials = scaled(20'000);
  for (std::int64_t i = 0; i < trials; ++i) {
    const double length = random.uniform(0.1, 2.0);
    const double tension = random.uniform(0.1, 1e3);
    const double modulus = random.uniform(1e9, 1e12);
    const double radius = random.uniform(1e-4, 1e-3);
    const double lambda = random.uniform();
    const double delta = random.uniform(1e-3, 0.05);
    const double more = 1.0 + random.uniform(1e-3, 1.0);
    const double force =
        deflection_force(make_string(length, tension, modulus, radius), lambda, delta);
    const auto with = [&](double t, double e, double r, double d) {
      return deflection_force(make_string(length, t, e, r), lambda, d);
    };
    CHECK(with(tension, modulus, radius, delta * more) > force);
    CHECK(with(tension * more, modulus, radius, delta) > force);
    CHECK(with(tension, modulus * more, radius, delta) > force);
    CHECK(with(tension, modulus, radius * more, delta) > force);
  }
}

TEST_CASE("stretching adds 0.4, 9.5 and 38 % of the tension at 1, 5 and 10 mm") {
  const StringConstants string = guqin_string();
  const auto percent = [&](double delta) {
    return 100.0 * deflect(string, 0.5, delta).axial_force / string.tension;
  };
  CHECK(std::fabs(percent(1e-3) - 0.4) < 0.05);
  CHECK(std::fabs(percent(5e-3) - 9.5) < 0.05);
  CHECK(std::fabs(percent(10e-3) - 38.0) < 0.5);
}

/// The tension that a string let go at lambda makes by its slopes, weighed as its fundamental feels
/// it, 2 cos^2(w t), over that of the moment it is let go: d'Alembert's two waves, sampled.
double felt_share(double lambda) {
  constexpr int kPlaces = 4000, kInstants = 1000;
  // Slope of the triangle, odd about its ends, period 2 L.
  const auto slope = [&](double x) {
    x -= 2.0 * std::floor(0.5 * x);
    const double inside = x < 1.0 ? x : 2.0 - x;
    return inside < lambda ? 1.0 / lambda : -1.0 / (1.0 - lambda);
  };
  double felt = 0.0, at_first = 0.0;
  for (int j = 0; j < kInstants; ++j) {
    const double t = (j + 0.5) / kInstants;  // half a swing is 1
    const double cosine = std::cos(3.14159265358979323846 * t);
    for (int i = 0; i < kPlaces; ++i) {
      const double x = (i + 0.5) / kPlaces;
      const double now = 0.5 * (slope(x - t) + slope(x + t));
      felt += 2.0 * cosine * cosine * now * now;
      at_first += slope(x) * slope(x);
    }
  }
  return felt / at_first;
}

TEST_CASE("a pluck of 5 mm glides 56 cents, of which 40 are the mean, and 79 at the peak") {
  const StringConstants string = guqin_string();
  const auto cents = [](double factor) { return 1200.0 * std::log2(factor); };
  const double stretch = deflect(string, 0.5, 5e-3).axial_force / string.tension;
  CHECK(std::fabs(cents(std::sqrt(1.0 + stretch)) - 79.0) < 0.5);
  CHECK(std::fabs(cents(std::sqrt(1.0 + 0.5 * stretch)) - 40.2) < 0.05);
  const double share = 8.0 / (3.14159265358979323846 * 3.14159265358979323846);
  CHECK(pitch_factor(string, 0.5, 5e-3) ==
        within(std::sqrt(1.0 + 0.5 * stretch * (1.0 + 0.5 * share)), 1e-14));
  CHECK(std::fabs(cents(pitch_factor(string, 0.5, 5e-3)) - 55.96) < 0.05);
  CHECK(pitch_factor(string, 0.5, 0.0) == 1.0);
}

TEST_CASE("a string glides as the tension of its swing asks, wherever it is drawn aside") {
  const StringConstants string = guqin_string();
  for (const double lambda : {0.02, 0.1, 0.3, 0.5, 0.9}) {
    CAPTURE(lambda);
    const double peak = deflect(string, lambda, 1e-3).axial_force / string.tension;
    const double pitch = pitch_factor(string, lambda, 1e-3);
    CHECK((pitch * pitch - 1.0) / peak == within(felt_share(lambda), 2e-3));
  }
  for (const double end : {0.0, 1.0, 1e-300, 1.0 - 0x1p-53}) {
    const double half = 0.5 * deflect(string, end, 5e-3).axial_force / string.tension;
    CHECK(pitch_factor(string, end, 5e-3) == within(std::sqrt(1.0 + half), 1e-14));
  }
}

TEST_CASE("30, 40 and 50 % more tension, modulus and radius are felt as computed by hand") {
  struct Row {
    double more;
    double tension_percent;
    double modulus_percent;
    double radius_percent;
  };
  constexpr std::array<Row, 3> kRows{
      {{1.3, 27.4, 2.6, 6.0}, {1.4, 36.5, 3.5, 8.3}, {1.5, 45.7, 4.3, 10.8}}};
  const auto force = [](double tension, double modulus, double radius) {
    return deflection_force(make_string(1.1, tension, modulus, radius), 0.5, 5e-3);
  };
  const double before = force(30.0, 1.9e11, 0.34e-3);
  const auto change = [&](double after) { return 100.0 * (after / before - 1.0); };
  for (const Row& row : kRows) {
    CHECK(std::fabs(change(force(30.0 * row.more, 1.9e11, 0.34e-3)) - row.tension_percent) < 0.06);
    CHECK(std::fabs(change(force(30.0, 1.9e11 * row.more, 0.34e-3)) - row.modulus_percent) < 0.06);
    CHECK(std::fabs(change(force(30.0, 1.9e11, 0.34e-3 * row.more)) - row.radius_percent) < 0.06);
  }
}

TEST_CASE("on an end the force jumps to T, and its stiffness at rest is infinite") {
  const StringConstants string = guqin_string();
  for (const double lambda : {0.0, 1.0}) {
    CHECK(deflect(string, lambda, 0.0).force == 0.0);
    CHECK(deflect(string, lambda, 0.0).slope == kInfinity);
    CHECK(deflect(string, lambda, 0.0).secant == kInfinity);
    CHECK(deflect(string, lambda, 1e-12).force == within(30.0, 1e-8));
  }
}

}  // namespace
}  // namespace hapticd::test
