// The work of a tick, shared among tools. Truths: the counts, and the exhaustive gap of every tool
// to strings and body.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/contact/tick_work.h"
#include "tests/core/simulation/ensemble.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// The bound that is promised, m.
constexpr long double kMaxPenetration = 1e-6L;

/// What two tools did in their last tick, of which one goes through the strings while the other
/// hovers.
std::array<ContactResult, 2> through_strings(bool first, std::int64_t work_budget) {
  const Vector3 hovers{0.5, 0.2, 0.0};
  const Vector3 above{0.5, 0.02, 0.05};
  const Vector3 beneath{0.52, -0.01, 0.06};
  Ensemble tools(2, {});
  tools.tick({first ? above : hovers, first ? hovers : above});
  tools.work_budget = work_budget;
  const SimulationTick& last = tools.tick({first ? beneath : hovers, first ? hovers : beneath});
  return {last.tool(0).contact, last.tool(1).contact};
}

}  // namespace

TEST_CASE("what a tool leaves of its share of the work is for those after it") {
  const std::array<ContactResult, 2> all = through_strings(false, 0);
  const std::int64_t work = tick_work(all[1]);
  REQUIRE(all[1].sub_steps > 3);
  REQUIRE(tick_work(all[0]) < work / 4);
  const std::int64_t budget = 3 * work / 2;
  CHECK_FALSE(through_strings(false, budget)[1].cut_short);
  CHECK(through_strings(true, budget)[0].cut_short);
  for (const ContactResult& tool : through_strings(true, 1)) CHECK(tool.sub_steps <= 1);
}

TEST_CASE("whatever work several tools are allowed, none comes to be in a string or the body") {
  SplitMix64 random(9);
  Ensemble tools(3, {});
  std::vector<Vector3> p(3, Vector3(0.5, 0.01, 0.06));
  std::vector<Vector3> goal = p;
  long double deepest = 1.0L;
  int cut = 0;
  for (std::int64_t tick = 0; tick < scaled(20'000); ++tick) {
    for (std::size_t k = 0; k < p.size(); ++k) {
      if ((goal[k] - p[k]).norm() < 1e-3) {
        goal[k] = {random.uniform(0.4, 0.6), random.uniform(-0.02, 0.02),
                   random.uniform(0.0, 0.12)};
      }
      p[k] += (goal[k] - p[k]) * std::min(1.0, 1e-3 / (goal[k] - p[k]).norm());
    }
    tools.work_budget = std::int64_t{1} << random.below(17);
    tools.tick(p);
    for (std::size_t k = 0; k < p.size(); ++k) {
      cut += tools.output().tool(k).contact.cut_short ? 1 : 0;
    }
    deepest = std::min(deepest, tools.minimum_gap());
  }
  MESSAGE("deepest " << static_cast<double>(deepest) << " m, " << cut << " ticks cut short");
  CHECK(deepest >= -kMaxPenetration);
  CHECK(cut > scaled(5'000));
}

}  // namespace hapticd::test
