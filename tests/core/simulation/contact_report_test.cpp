// The report of contacts against distances computed from the scene, and its forces against the
// wrench of the tick.
#include "core/simulation/contact_report.h"

#include <doctest/doctest.h>

#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// Three fingertips in a row across the strings.
std::vector<Sphere> row_of_three() {
  return {{Vector3(0.0, 0.0, 0.0), 5e-3},
          {Vector3(0.0, 1e-3, 0.02), 5e-3},
          {Vector3(0.0, 0.0, 0.04), 5e-3}};
}

StringParameters rigid_line() {
  StringParameters line;
  line.model = StringContact::kStraight;
  line.max_level = StringDetail::kLine;
  line.k_s = 1e6;
  return line;
}

}  // namespace

TEST_CASE("every pair that bears force is reported where it is, and the forces add up") {
  Instrument play(3, rigid_line(), {}, row_of_three());
  play.tick(Vector3(0.5, 0.02, 0.0));
  for (int k = 1; k <= 40; ++k) play.tick(Vector3(0.5, 0.02 - 0.0005 * k, 0.0));
  ContactReport report;
  report_contacts(play.simulation().memory(), play.simulation().strings().sharing(), 0, report);
  REQUIRE(report.contacts.size() >= 2);
  CHECK(report.total == static_cast<std::int32_t>(report.contacts.size()));
  Vector3 sum(0.0, 0.0, 0.0);
  double last_gap = -1.0;
  for (const ContactTick& contact : report.contacts) {
    CHECK(contact.gap >= last_gap);
    last_gap = contact.gap;
    const Vector3 n = to_vector(contact.nhat_OG_W);
    CHECK(n.norm() == within(1.0, 1e-12));
    sum += contact.force * n;
    // A point of the tool's surface, a gap above the line's.
    const Vector3 p = to_vector(contact.p_WC);
    const double z = 0.02 * contact.key.obstacle;
    const double from_axis = std::hypot(p.y(), p.z() - z);
    CHECK(std::abs(from_axis - play.capsules_W[0].r - contact.gap) < 1e-12);
    CHECK(contact.gap < 2.1 * play.scene().options.skin);
  }
  CHECK((sum - play.output().tool(0).F_computed_H_W.f).norm() < 1e-6);
  CHECK(sum.y() > 1.0);
}

TEST_CASE("a tool that is far from everything has nothing to report") {
  Instrument play(3, rigid_line(), {}, row_of_three());
  play.tick(Vector3(0.5, 0.05, 0.0));
  ContactReport report;
  report.total = 7;
  report_contacts(play.simulation().memory(), play.simulation().strings().sharing(), 0, report);
  CHECK(report.contacts.empty());
  CHECK(report.total == 0);
}

}  // namespace hapticd::test
