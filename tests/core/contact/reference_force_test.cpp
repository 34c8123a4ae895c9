// What the default sub-steps per tick cost in force accuracy: the same input replayed with 400
// sub-steps is the truth.
#include <doctest/doctest.h>

#include "tests/core/contact/rendering_fixture.h"
#include "tests/core/contact/session_run.h"

namespace hapticd::test {
namespace {

constexpr double kAllowedRmsPercent = 0.5;
constexpr double kAllowedMax = 0.060;
constexpr double kRate = 1000.0;

void check(const ContactSession& session) {
  const SessionRun reference = play(session, reference_options(), kRate);
  const ForceError error =
      force_error(play(session, ContactOptions{}, kRate).f_H_W, reference.f_H_W);
  MESSAGE("rms " << error.rms_percent << " %, max " << 1e3 * error.max_newton
                 << " mN, largest force " << error.largest_force << " N");
  CHECK(error.largest_force > 1.0);
  CHECK(error.rms_percent <= kAllowedRmsPercent);
  CHECK(error.max_newton <= kAllowedMax);
}

}  // namespace

TEST_CASE("the default sub-steps render a single press within half a percent of four hundred") {
  check(single_press());
}

TEST_CASE("the default sub-steps render two lines at once within half a percent of four hundred") {
  check(two_lines());
}

TEST_CASE(
    "the default sub-steps render a line and a pillar at once within half a percent of four "
    "hundred") {
  check(line_and_pillar());
}

TEST_CASE(
    "the default sub-steps render the switch from pillar to line and back within half a percent of "
    "four hundred") {
  check(contact_switch());
}

TEST_CASE(
    "the default sub-steps render a twisted wedge between two lines within half a percent of four "
    "hundred") {
  check(twisted_wedge());
}

}  // namespace hapticd::test
