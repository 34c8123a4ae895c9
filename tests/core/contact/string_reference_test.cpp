// The force of strings that yield under a moving tool, beside the exact statics of every place of
// the hand. With friction the way there counts, which the statics does not know:
// there the same input with 400 sub-steps per tick shows that the default ones are enough.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/math/elementary.h"
#include "tests/core/contact/rendering_fixture.h"
#include "tests/core/contact/session_statics.h"

namespace hapticd::test {
namespace {

constexpr double kAllowedRmsPercent = 0.5;
constexpr double kAllowedMax = 0.060;
constexpr double kRate = 1000.0;
/// Of all ticks, those in which a slip may lead to another rest than the statics follows.
constexpr double kOtherShare = 0.02;

/// A disc across the strings instead of the sessions' long tool: it meets each string at one place,
/// as the product's strings and those of the statics have it, which bend at one vertex.
std::vector<Sphere> disc() {
  constexpr int kCount = 48;
  std::vector<Sphere> spheres;
  for (int i = 0; i < kCount; ++i) {
    const double angle = 2.0 * kPi * i / kCount;
    spheres.push_back({{0.0, 0.020 * std::sin(angle), 0.025 * std::cos(angle)}, 5e-3});
  }
  return spheres;
}

/// Every session with its lines as strings; the errors of each.
void check_sessions(const SessionStrings& strings) {
  for (ContactSession session : contact_sessions()) {
    session.tool_G = disc();
    const StaticsError error = compare_with_statics(session, kRate, &strings);
    MESSAGE(std::string(session.name)
            << ": rms " << error.force.rms_percent << " %, max " << 1e3 * error.force.max_newton
            << " mN, largest force " << error.force.largest_force << " N, " << error.slips
            << " jumps, " << error.others << " ticks at another rest");
    CAPTURE(std::string(session.name));
    CHECK(error.converged);
    CHECK(error.force.largest_force > 0.3);
    CHECK(error.force.rms_percent <= kAllowedRmsPercent);
    CHECK(error.force.max_newton <= kAllowedMax);
    CHECK(error.others <= kOtherShare * error.ticks);
  }
}

}  // namespace

TEST_CASE("soft strings are felt within half a percent of the exact statics") {
  SessionStrings strings;
  strings.parameters.tension = 30.0;
  strings.parameters.youngs_modulus = 1e8;
  strings.instrument.lateral_force = true;
  check_sessions(strings);
}

TEST_CASE("taut strings are felt within half a percent of the exact statics") {
  SessionStrings strings;
  strings.parameters.tension = 200.0;
  strings.parameters.youngs_modulus = 1e9;
  strings.parameters.contact_stiffness = 600.0;
  strings.instrument.lateral_force = true;
  check_sessions(strings);
}

TEST_CASE("the default sub-steps render rough strings within half a percent of four hundred") {
  SessionStrings strings;
  strings.parameters.tension = 60.0;
  strings.parameters.youngs_modulus = 1e8;
  strings.parameters.friction_coefficient = 0.4;
  strings.instrument.friction = true;
  strings.instrument.lateral_force = true;
  for (const ContactSession& session : contact_sessions()) {
    const SessionRun reference = play(session, reference_options(), kRate, &strings);
    const ForceError error =
        force_error(play(session, ContactOptions{}, kRate, &strings).f_H_W, reference.f_H_W);
    MESSAGE(std::string(session.name)
            << ": rms " << error.rms_percent << " %, max " << 1e3 * error.max_newton
            << " mN, largest force " << error.largest_force << " N");
    CAPTURE(std::string(session.name));
    CHECK(error.largest_force > 0.3);
    CHECK(error.rms_percent <= kAllowedRmsPercent);
    CHECK(error.max_newton <= kAllowedMax);
  }
}

}  // namespace hapticd::test
