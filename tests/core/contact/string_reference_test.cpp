// What the default sub-steps cost in the force of strings that yield: the same input replayed with
// 400 sub-steps per tick is the truth.
#include <doctest/doctest.h>

#include <string>

#include "tests/core/contact/rendering_fixture.h"
#include "tests/core/contact/session_run.h"

namespace hapticd::test {
namespace {

constexpr double kAllowedRmsPercent = 0.5;
constexpr double kAllowedMax = 0.060;
constexpr double kRate = 1000.0;

/// Every session with its lines as strings; the errors of each.
void check_sessions(const SessionStrings& strings) {
  for (const ContactSession& session : contact_sessions()) {
    const SessionRun reference = play(session, reference_options(), kRate, &strings);
    const SessionRun run = play(session, ContactOptions{}, kRate, &strings);
    const ForceError error = force_error(run.f_H_W, reference.f_H_W);
    MESSAGE(std::string(session.name)
            << ": rms " << error.rms_percent << " %, max " << 1e3 * error.max_newton
            << " mN, largest force " << error.largest_force << " N, most sub-steps "
            << run.most_sub_steps);
    CAPTURE(std::string(session.name));
    CHECK(error.largest_force > 0.3);
    CHECK(error.rms_percent <= kAllowedRmsPercent);
    CHECK(error.max_newton <= kAllowedMax);
  }
}

}  // namespace

TEST_CASE("the default sub-steps render soft strings within half a percent of four hundred") {
  SessionStrings strings;
  strings.parameters.tension = 30.0;
  strings.parameters.youngs_modulus = 1e8;
  check_sessions(strings);
}

TEST_CASE("the default sub-steps render taut strings within half a percent of four hundred") {
  SessionStrings strings;
  strings.parameters.tension = 200.0;
  strings.parameters.youngs_modulus = 1e9;
  strings.parameters.contact_stiffness = 600.0;
  check_sessions(strings);
}

TEST_CASE("the default sub-steps render rough strings within half a percent of four hundred") {
  SessionStrings strings;
  strings.parameters.tension = 60.0;
  strings.parameters.youngs_modulus = 1e8;
  strings.parameters.friction_coefficient = 0.4;
  strings.instrument.friction = true;
  strings.instrument.lateral_force = true;
  check_sessions(strings);
}

}  // namespace hapticd::test
