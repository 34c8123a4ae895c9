// The force that the default options render while a tool of many contacts moves, beside the exact
// statics of every place of the hand.
#include <doctest/doctest.h>

#include "tests/core/contact/session_statics.h"

namespace hapticd::test {
namespace {

constexpr double kAllowedRmsPercent = 0.5;
constexpr double kAllowedMax = 0.060;
constexpr double kRate = 1000.0;
/// Of all ticks, those in which a slip may lead to another rest than the statics follows.
constexpr double kOtherShare = 0.02;

void check(const ContactSession& session) {
  const StaticsError error = compare_with_statics(session, kRate);
  MESSAGE("rms " << error.force.rms_percent << " %, max " << 1e3 * error.force.max_newton
                 << " mN, largest force " << error.force.largest_force << " N, " << error.slips
                 << " jumps, " << error.others << " ticks at another rest");
  CHECK(error.converged);
  CHECK(error.force.largest_force > 1.0);
  CHECK(error.force.rms_percent <= kAllowedRmsPercent);
  CHECK(error.force.max_newton <= kAllowedMax);
  CHECK(error.others <= kOtherShare * error.ticks);
}

}  // namespace

TEST_CASE("a single press is felt within half a percent of the exact statics") {
  check(single_press());
}

TEST_CASE("two lines at once are felt within half a percent of the exact statics") {
  check(two_lines());
}

TEST_CASE("a line and a pillar at once are felt within half a percent of the exact statics") {
  check(line_and_pillar());
}

TEST_CASE(
    "the switch from pillar to line and back is felt within half a percent of the exact statics") {
  check(contact_switch());
}

TEST_CASE("a twisted wedge between two lines is felt within half a percent of the exact statics") {
  check(twisted_wedge());
}

TEST_CASE("a truth with surfaces 0.1 mm too fat is not what is felt: the control") {
  for (const ContactSession& session : contact_sessions()) {
    const StaticsError error = compare_with_statics(session, kRate / 10, nullptr, 1e-4);
    CHECK(error.converged);
    CHECK(error.force.rms_percent > kAllowedRmsPercent);
  }
}

}  // namespace hapticd::test
