// The truth about pitch judged before it judges: closed forms, and convergence.
#include "tests/truth/pitch_truth.h"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>

namespace hapticd::test {
namespace {

/// The first string of a Guqin.
GlidingString guqin() {
  GlidingString string;
  string.axial_stiffness = 1.9e11 * 3.14159265358979 * 0.34e-3 * 0.34e-3;
  return string;
}

double cents(double frequency, double other) { return 1200.0 * std::log2(frequency / other); }

/// Period of q'' + w^2 q (1 + e q^2) = 0 from rest at 1, in units of 2 pi / w: an integral without
/// singularities, by the trapezoidal rule, which is exact for periodic functions.
double duffing_period(double e) {
  constexpr int kPoints = 64;
  double sum = 0.0;
  for (int k = 0; k < kPoints; ++k) {
    const double sine = std::sin(2.0 * 3.14159265358979 * k / kPoints);
    sum += 1.0 / std::sqrt(1.0 + 0.5 * e * (1.0 + sine * sine));
  }
  return sum / kPoints;
}

}  // namespace

TEST_CASE("a string that does not stretch keeps its pitch") {
  GlidingString string = guqin();
  string.axial_stiffness = 0.0;
  CHECK(std::fabs(cents(mean_frequency(string, 20 / 65.4, 4, 400'000), 65.4)) < 0.1);
}

TEST_CASE("one mode has the period of Duffing's equation") {
  GlidingString string = guqin();
  string.decay = 1e9;
  const double q = 8.0 * string.pluck_deflection / (3.14159265358979 * 3.14159265358979);
  const double slope = 3.14159265358979 * q / (2.0 * string.length);
  const double e = string.axial_stiffness * slope * slope / string.tension;
  const double expected = 65.4 / duffing_period(e);
  REQUIRE(cents(expected, 65.4) > 30.0);
  CHECK(std::fabs(cents(mean_frequency(string, 20.0 / expected, 1, 400'000), expected)) < 0.05);
}

TEST_CASE("more modes and more steps do not change the pitch of a pluck") {
  for (const double lambda : {0.1, 0.5}) {
    GlidingString string = guqin();
    string.pluck_lambda = lambda;
    const double finest = mean_frequency(string, 0.1, 256, 3'200'000);
    CHECK(std::fabs(cents(mean_frequency(string, 0.1, 96, 800'000), finest)) < 1.0);
  }
}

}  // namespace hapticd::test
