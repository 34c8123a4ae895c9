// The extremes a string must survive: no number leaves it that is not one, and what is finite in
// the limit is finite.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/instrument/deflection.h"
#include "tests/core/instrument/strings.h"
#include "tests/support/no_heap.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kDenormal = std::numeric_limits<double>::denorm_min();
constexpr std::array<double, 9> kLambdas{0.0, kDenormal, 1e-200,        1e-9, 0.3,
                                         0.5, 0.999,     1.0 - 0x1p-53, 1.0};

/// All of it is a number >= 0, but the lateral force, which has a sign.
void check_sane(const Deflection& bent) {
  CHECK(bent.force >= 0.0);
  CHECK(bent.slope >= 0.0);
  CHECK(bent.secant >= 0.0);
  CHECK(bent.energy >= 0.0);
  CHECK(bent.axial_force >= 0.0);
  CHECK(std::isfinite(bent.lateral_force));
  CHECK(std::isfinite(bent.force));
  CHECK(std::isfinite(bent.energy));
  CHECK(std::isfinite(bent.axial_force));
}

void check_sane(const SeriesDeflection& at, double displacement, double stiffness) {
  CHECK(at.delta >= 0.0);
  CHECK(at.delta <= displacement);
  CHECK(at.force >= 0.0);
  CHECK(at.force <= stiffness * displacement);
}

/// Every string of these parameters at every place and deflection.
void check_everywhere(const StringParameters& parameters) {
  REQUIRE(!check_string(parameters).has_value());
  const StringConstants string = derive_string(parameters);
  CAPTURE(string.length);
  CAPTURE(string.tension);
  CAPTURE(string.axial_stiffness);
  for (const double lambda : kLambdas) {
    CAPTURE(lambda);
    CHECK(!std::isnan(small_deflection_stiffness(string, lambda)));
    for (const double delta : {0.0, -0.0, kDenormal, 1e-310, 1e-200, 1e-145, 1e-100, 1e-85, 1e-30,
                               1e-9, 1e-4, 0.02, 1.0, 1e7, 1e100}) {
      CAPTURE(delta);
      check_sane(deflect(string, lambda, delta));
      CHECK(deflection_force(string, lambda, delta) == deflect(string, lambda, delta).force);
      CHECK(pitch_factor(string, lambda, delta) >= 1.0);
      for (const double stiffness : {1e-3, 1000.0, 1e9}) {
        check_sane(deflect_in_series(string, lambda, delta, stiffness), delta, stiffness);
      }
    }
  }
}

TEST_CASE("delta 0: no force, no energy, no lateral force") {
  for (const double tension : {0.0, 30.0}) {
    const StringConstants string = make_string(1.1, tension, 1.9e11, 0.34e-3);
    for (const double lambda : kLambdas) {
      const Deflection bent = deflect(string, lambda, 0.0);
      CHECK(bent.force == 0.0);
      CHECK(bent.energy == 0.0);
      CHECK(bent.axial_force == 0.0);
      CHECK(bent.lateral_force == 0.0);
      CHECK(!std::isnan(bent.slope));
      CHECK(!std::isnan(bent.secant));
      CHECK(deflect_in_series(string, lambda, 0.0, 1000.0).force == 0.0);
      CHECK(deflect_in_series(string, lambda, 0.0, 1000.0).delta == 0.0);
    }
  }
}

TEST_CASE("lambda 0, delta 1e-9 .. 20 mm: finite, and bounded by the contact stiffness") {
  const StringConstants string = guqin_string();
  for (double delta = 1e-9; delta < 0.02; delta *= 1.3) {
    check_sane(deflect(string, 0.0, delta));
    const SeriesDeflection at = deflect_in_series(string, 0.0, delta, 1000.0);
    check_sane(at, delta, 1000.0);
    CHECK(at.force == 1000.0 * delta);  // less than T: the string does not yield
  }
}

TEST_CASE("radius 0, 1e-9 and 1 m") {
  for (const double radius : {0.0, 1e-9, 1.0}) {
    check_everywhere(string_parameters(1.1, 30.0, 1.9e11, radius));
  }
}

TEST_CASE("lengths from 1e-6 to 1e7 m") {
  for (const double length : {1e-6, 1e-3, 1.0, 1e3, 1e7}) {
    check_everywhere(string_parameters(length, 30.0, 1.9e11, 0.34e-3));
  }
}

TEST_CASE("A == B, and lengths that no square can hold") {
  for (const double length : {0.0, kDenormal, 1e-200, 1e-10, 1.001e-9}) {
    check_everywhere(string_parameters(length, 30.0, 1.9e11, 0.34e-3));
  }
}

TEST_CASE("tension 0 and Young's modulus 0, each and both") {
  for (const double tension : {0.0, kDenormal, 30.0, 1e6}) {
    for (const double modulus : {0.0, kDenormal, 1.9e11}) {
      check_everywhere(string_parameters(1.1, tension, modulus, 0.34e-3));
    }
  }
}

TEST_CASE("the stiffest string of the ranges, of every length") {
  for (const double length : {1.001e-9, 1e-6, 1.0, 1e7}) {
    check_everywhere(string_parameters(length, 1e6, 1e13, 1.0));
  }
}

TEST_CASE("a stiff cable answers within the precision of a double") {
  // F = E A (2 delta / L)^3 at mid-span of a slack one, delta << L; E A = pi 1e13 N.
  const StringConstants cable = make_string(2.0, 0.0, 1e13, 1.0);
  const double cube = std::pow(1e-6, 3.0);
  const double stiffness = 3.14159265358979323846e13;
  CHECK(deflect(cable, 0.5, 1e-6).force == within(stiffness * cube, 1e-11));
}

TEST_CASE("deflecting a string leaves the heap alone") {
  const StringConstants string = guqin_string();
  const NoHeapScope scope;
  double sum = 0.0;
  sum += deflect(string, 0.3, 0.01).force;
  sum += deflect_in_series(string, 0.3, 0.01, 1000.0).force;
  sum += pitch_factor(string, 0.3, 0.01);
  sum += check_string(StringParameters{}).has_value() ? 1.0 : 0.0;
  const std::int64_t touched = scope.count();
  CHECK(touched == 0);
  CHECK(sum > 0.0);
}

}  // namespace
}  // namespace hapticd::test
