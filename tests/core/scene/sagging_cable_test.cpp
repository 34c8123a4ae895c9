// A slack cable: its pieces lie on the parabola, and each yields as the cable would. Truth: closed
// forms.
#include "core/scene/sagging_cable.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/instrument/deflection.h"
#include "core/math/elementary.h"
#include "tests/core/scene/scene_builder.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

StringDescription cable(double sag) {
  StringDescription cable = string_between({-0.3, 0.2, 0.1}, {0.5, 0.25, -0.1});
  cable.parameters.tension = 4.0;
  cable.parameters.radius = 3e-3;
  cable.parameters.youngs_modulus = 1e8;
  cable.sag = sag;
  return cable;
}

/// Height of the parabola under the point of the chord at lambda.
Vector3 parabola(const StringDescription& cable, double lambda) {
  const Vector3 a = to_vector(cable.parameters.p_WA);
  const Vector3 b = to_vector(cable.parameters.p_WB);
  return a + lambda * (b - a) - Vector3(0.0, 4.0 * cable.sag * lambda * (1.0 - lambda), 0.0);
}

/// Its pieces against the law of a cable of axial stiffness EA, N.
void check_pieces(const StringDescription& whole, double EA) {
  const std::vector<StringParameters> pieces = cable_of(whole);
  const double span = (to_vector(whole.parameters.p_WB) - to_vector(whole.parameters.p_WA)).norm();
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const StringConstants piece = derive_string(pieces[i]);
    const double lambda = (static_cast<double>(i) + 0.5) / static_cast<double>(pieces.size());
    const double c = lambda * (1.0 - lambda);
    for (const double delta : {1e-6, 1e-4, 1e-3}) {
      CAPTURE(i);
      CAPTURE(delta);
      const double wanted = whole.parameters.tension * delta / (c * span) +
                            EA * delta * delta * delta / (2.0 * c * c * span * span * span);
      CHECK(deflect(piece, 0.5, delta).force == within(wanted, 2e-3));
    }
  }
}

}  // namespace

TEST_CASE("a string without sag is one piece, itself") {
  const StringDescription straight = cable(0.0);
  const std::vector<StringParameters> pieces = cable_of(straight);
  REQUIRE(pieces.size() == 1);
  CHECK(pieces[0].p_WA == straight.parameters.p_WA);
  CHECK(pieces[0].tension == straight.parameters.tension);
  CHECK(cable_error(0.0) == 0.0);
}

TEST_CASE("the pieces hang together, end to end on the parabola, and stray no further than told") {
  for (const double sag : {1e-6, 1e-3, 0.01, 0.05, 0.06, 0.5, 10.0}) {
    CAPTURE(sag);
    const StringDescription whole = cable(sag);
    const std::vector<StringParameters> pieces = cable_of(whole);
    CHECK(pieces.size() == static_cast<std::size_t>(cable_pieces(sag)));
    CHECK(pieces.front().p_WA == whole.parameters.p_WA);
    CHECK((to_vector(pieces.back().p_WB) - to_vector(whole.parameters.p_WB)).norm() <= 1e-15);
    double worst = 0.0;
    const auto count = static_cast<double>(pieces.size());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (i > 0) CHECK(pieces[i].p_WA == pieces[i - 1].p_WB);
      const Vector3 a = to_vector(pieces[i].p_WA);
      const Vector3 b = to_vector(pieces[i].p_WB);
      for (int k = 0; k <= 20; ++k) {
        const double share = k / 20.0;
        const Vector3 off =
            parabola(whole, (static_cast<double>(i) + share) / count) - (a + share * (b - a));
        worst = std::max(worst, off.norm());
      }
    }
    CHECK(worst <= cable_error(sag) * (1.0 + 1e-9) + 1e-15);
    CHECK(worst >= 0.99 * cable_error(sag));
    if (sag <= kSlightSag) CHECK(worst <= 0.25e-3);
  }
}

TEST_CASE("pushed in its middle a piece yields as the cable would there") {
  StringDescription whole = cable(0.02);
  const double area = kPi * whole.parameters.radius * whole.parameters.radius;
  check_pieces(whole, whole.parameters.youngs_modulus * area);
  whole.parameters.axial_stiffness = 9e3;
  check_pieces(whole, 9e3);
}

TEST_CASE("cables that hang level, upright or hardly at all have pieces of finite length") {
  SplitMix64 random(1);
  for (std::int64_t k = 0; k < scaled(1000); ++k) {
    StringDescription cable =
        string_between(random_vector(random, 1.0), random_vector(random, 1.0));
    cable.sag = std::pow(10.0, random.uniform(-9.0, 1.0));
    for (const StringParameters& piece : cable_of(cable)) {
      const StringConstants constants = derive_string(piece);
      CHECK(constants.length > 0.0);
      CHECK(std::isfinite(constants.tension));
      CHECK(std::isfinite(constants.axial_stiffness));
    }
  }
}

}  // namespace hapticd::test
