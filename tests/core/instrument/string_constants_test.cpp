// The constants a tick reads of a string, and the frozen k_s of rigid strings.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "core/instrument/deflection.h"
#include "core/instrument/mode_series.h"
#include "core/instrument/string_parameters.h"
#include "tests/core/instrument/strings.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kPiTruth = 3.14159265358979323846;

TEST_CASE("length and axial stiffness are |AB| and E pi R^2") {
  StringParameters parameters;
  parameters.p_WA = {1.0, 2.0, 3.0};
  parameters.p_WB = {3.0, 5.0, 9.0};
  parameters.youngs_modulus = 2e11;
  parameters.radius = 1e-3;
  const StringConstants string = derive_string(parameters);
  CHECK(string.length == 7.0);
  CHECK(string.axial_stiffness == within(2e5 * kPiTruth, 1e-14));
  CHECK(string.tension == 30.0);
}

TEST_CASE("an axial stiffness that is given wins over E pi R^2, 0 too") {
  StringParameters parameters = string_parameters(1.1, 30.0, 1.9e11, 0.34e-3);
  for (const double given : {0.0, 13400.0, 1e12}) {
    parameters.axial_stiffness = given;
    CHECK(!check_string(parameters).has_value());
    CHECK(derive_string(parameters).axial_stiffness == given);
    CHECK(axial_stiffness_of(parameters) == given);
  }
}

TEST_CASE("everything else is passed on as it is") {
  StringParameters parameters = string_parameters(1.1, 30.0, 1.9e11, 0.34e-3);
  parameters.decay = 0.7;
  parameters.loss_n2 = 0.01;
  parameters.touch_decay = 0.04;
  parameters.k_s = 0.109;
  parameters.contact_stiffness = 800.0;
  parameters.inharmonicity = 1e-3;
  parameters.friction_coefficient = 0.4;
  parameters.model = StringContact::kYielding;
  parameters.max_level = StringDetail::kFundamental;
  const StringConstants string = derive_string(parameters);
  CHECK(string.decay == 0.7);
  CHECK(string.loss_n2 == 0.01);
  CHECK(string.touch_decay == 0.04);
  CHECK(string.k_s == 0.109);
  CHECK(string.contact_stiffness == 800.0);
  CHECK(string.inharmonicity == 1e-3);
  CHECK(string.friction_coefficient == 0.4);
  CHECK(string.model == StringContact::kYielding);
  CHECK(string.max_level == StringDetail::kFundamental);
}

TEST_CASE("the tuning wins over the density, and without it the density tunes") {
  // 0.34 mm of steel at 30 N between ends 1.1 m apart sound at 46.6 Hz.
  StringParameters parameters = string_parameters(1.1, 30.0, 1.9e11, 0.34e-3);
  parameters.linear_density = 7850.0 * kPiTruth * 0.34e-3 * 0.34e-3;
  CHECK(derive_string(parameters).frequency == 110.0);
  parameters.frequency = 0.0;
  CHECK(derive_string(parameters).frequency == within(46.6, 1e-3));
}

TEST_CASE("where tension tunes, the density wins over the frequency and the pitch goes as a root") {
  StringParameters parameters = string_parameters(1.1, 30.0, 1.9e11, 0.34e-3);
  parameters.tuning = StringTuning::kTension;
  CHECK(derive_string(parameters).frequency == 110.0);
  parameters.linear_density = tuned_density(1.1, 30.0, 98.0);
  CHECK(derive_string(parameters).frequency == within(98.0, 1e-14));
  parameters.tension = 120.0;
  const StringConstants tighter = derive_string(parameters);
  CHECK(tighter.frequency == within(196.0, 1e-14));
  CHECK(tighter.modal_mass == within(0.55 * parameters.linear_density, 1e-14));
  parameters.tuning = StringTuning::kFrequency;
  CHECK(derive_string(parameters).frequency == 110.0);
}

TEST_CASE("the modal mass makes tension and tuning agree") {
  // Mode 1 of an ideal string: stiffness T pi^2 / (2 L), and m omega^2 is the same.
  const StringConstants string = make_string(1.1, 30.0, 1.9e11, 0.34e-3);
  const double omega = 2.0 * kPiTruth * 110.0;
  const double stiffness = 30.0 * kPiTruth * kPiTruth / (2.0 * 1.1);
  CHECK(string.modal_mass * omega * omega == within(stiffness, 1e-14));
  // From a density: mu L / 2.
  StringParameters parameters = string_parameters(1.1, 30.0, 1.9e11, 0.34e-3);
  parameters.frequency = 0.0;
  parameters.linear_density = 3e-3;
  CHECK(derive_string(parameters).modal_mass == within(1.65e-3, 1e-14));
}

void check_silent(const StringParameters& parameters) {
  REQUIRE(!check_string(parameters).has_value());
  const StringConstants string = derive_string(parameters);
  CHECK(string.frequency == 0.0);
  CHECK(string.modal_mass == 0.0);
}

TEST_CASE("a string without tuning, tension or length never sounds") {
  StringParameters parameters = string_parameters(1.1, 30.0, 1.9e11, 0.34e-3);
  parameters.frequency = 0.0;
  check_silent(parameters);
  check_silent(string_parameters(1.1, 0.0, 1.9e11, 0.34e-3));
  check_silent(string_parameters(0.0, 30.0, 1.9e11, 0.34e-3));
  StringParameters slack = string_parameters(1.1, 0.0, 1.9e11, 0.34e-3);
  slack.frequency = 0.0;
  slack.linear_density = 3e-3;
  check_silent(slack);
}

TEST_CASE("a tuning that no mass of a double gives never sounds") {
  StringParameters parameters = string_parameters(1.1, 30.0, 1.9e11, 0.34e-3);
  parameters.frequency = std::numeric_limits<double>::denorm_min();
  check_silent(parameters);
  parameters.frequency = 2e4;
  parameters.tension = std::numeric_limits<double>::denorm_min();
  check_silent(parameters);
}

TEST_CASE("a string from A to A, or to a point it cannot be told from, is a rigid sphere") {
  for (const double length : {0.0, 1e-320, 1e-200, 0.99e-9}) {
    const StringConstants string = make_string(length, 30.0, 1.9e11, 0.34e-3);
    CHECK(string.length == 0.0);
    CHECK(string.model == StringContact::kStraight);
    CHECK(string.max_level == StringDetail::kLine);
  }
  const StringConstants shortest = make_string(1.01e-9, 30.0, 1.9e11, 0.34e-3);
  CHECK(shortest.length == 1.01e-9);
  CHECK(shortest.model == StringContact::kYielding);
}

TEST_CASE("inharmonicity stretches the upper modes and leaves the tuning") {
  for (const double B : {0.0, 1e-4, 0.1}) {
    StringConstants string = make_string(1.1, 30.0, 1.9e11, 0.34e-3);
    string.frequency = 110.0;
    string.inharmonicity = B;
    const ModeSeries series = mode_series(string);
    for (const int n : {1, 2, 7, 64}) {
      const long double square = static_cast<long double>(n) * static_cast<long double>(n);
      const long double stretch =
          (1.0L + static_cast<long double>(B) * square) / (1.0L + static_cast<long double>(B));
      const long double truth = 110.0L * std::sqrt(square * stretch);
      CHECK(relative_error(series.frequency(n), truth) < 1e-15L);
    }
  }
}

TEST_CASE("k_s from the device is k0 over its largest stiffness") {
  // k0 = 30 / (1.1 / 4) = 109 N/m: 0.109 of a device with 1 kN/m.
  CHECK(k_s_from_device(1.1, 30.0, 0.5, 1000.0) == within(0.12 / 1.1, 1e-14));
  CHECK(k_s_from_device(1.1, 30.0, 0.1, 1000.0) == within(30.0 / (1.1 * 0.09) / 1000.0, 1e-14));
}

/// The rigid law: the displacement D of the hand is k_s times the deflection.
double rigid_force(double tension, double k_s, double displacement) {
  const StringConstants string = make_string(1.1, tension, 0.0, 0.34e-3);
  return deflection_force(string, 0.5, displacement / k_s);
}

TEST_CASE("with k_s frozen at the reference, half as much tension again is felt") {
  const double frozen = k_s_from_device(1.1, 30.0, 0.5, 1000.0);
  const double before = rigid_force(30.0, frozen, 1e-4);
  const double after = rigid_force(45.0, frozen, 1e-4);
  CHECK(after / before == within(1.5, 1e-12));
}

TEST_CASE("were k_s computed anew for each tension, no tension could be felt") {
  const double before = rigid_force(30.0, k_s_from_device(1.1, 30.0, 0.5, 1000.0), 1e-4);
  const double after = rigid_force(45.0, k_s_from_device(1.1, 45.0, 0.5, 1000.0), 1e-4);
  CHECK(after / before == within(1.0, 1e-5));
}

}  // namespace
}  // namespace hapticd::test
