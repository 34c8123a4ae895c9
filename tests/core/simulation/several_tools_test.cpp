// Several tools on shared strings and a body: whatever they do to each other, none comes to be in a
// string or body.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "tests/core/simulation/ensemble.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// The bound that is promised, m.
constexpr long double kMaxPenetration = 1e-6L;

/// Where hands wander.
struct Region {
  const char* name;
  Vector3 from;
  Vector3 to;
};

/// A hand that wanders: presses, drags, jumps.
struct Wanderer {
  Vector3 p{0.5, 0.01, 0.06};
  Vector3 goal{0.5, 0.01, 0.06};
  double speed = 0.1;

  void move(const Region& region, SplitMix64& random) {
    if ((goal - p).norm() < 1e-4) {
      for (Eigen::Index k = 0; k < 3; ++k) goal[k] = random.uniform(region.from[k], region.to[k]);
      speed = random.chance(0.3) ? random.uniform(0.5, 3.0) : random.uniform(0.01, 0.5);
      if (random.chance(0.1)) p = goal;
    }
    const Vector3 way = goal - p;
    const double length = way.norm();
    if (length > 0.0) p += way * std::min(1.0, speed * 1e-3 / length);
  }
};

/// What became of a session.
struct Outcome {
  long double worst = 0.0L;  ///< penetration, as a negative gap, m
  int shared = 0;            ///< strings held by two or more, summed over ticks
  int recovering = 0;        ///< ticks of tools that were pushed out of something
};

Outcome wander(Ensemble& ensemble, const Region& region, int ticks, SplitMix64& random) {
  Outcome outcome;
  std::vector<Wanderer> hands(ensemble.simulation().tool_count());
  for (std::size_t k = 0; k < hands.size(); ++k) {
    hands[k].p = hands[k].goal = {0.5 + 0.02 * static_cast<double>(k), 0.03, 0.06};
  }
  for (int tick = 0; tick < ticks; ++tick) {
    std::vector<Vector3> p;
    for (Wanderer& hand : hands) {
      hand.move(region, random);
      p.push_back(hand.p);
    }
    ensemble.tick(p);
    outcome.worst = std::min(outcome.worst, ensemble.minimum_gap());
    for (std::int32_t s = 0; s < 7; ++s) outcome.shared += ensemble.shape(s).size() > 3 ? 1 : 0;
    for (std::size_t k = 0; k < hands.size(); ++k) {
      const ContactStatus status = ensemble.output().tool(k).contact.status;
      if (status == ContactStatus::kRecovering) ++outcome.recovering;
    }
  }
  return outcome;
}

}  // namespace

TEST_CASE("five tools that wander over seven strings and a body never come to be in any of them") {
  const Region regions[] = {
      {"all strings", {0.2, -0.03, -0.01}, {0.6, 0.012, 0.13}},
      {"two strings", {0.45, -0.015, 0.035}, {0.55, 0.015, 0.065}},
      {"one place", {0.495, -0.012, 0.03}, {0.505, 0.012, 0.05}},
  };
  int shared = 0;
  for (const Region& region : regions) {
    for (const bool friction : {false, true}) {
      const std::string where = region.name;
      CAPTURE(where);
      CAPTURE(friction);
      SplitMix64 random(friction ? 12 : 11);
      EnsembleOptions options;
      options.instrument.friction = friction;
      options.string.friction_coefficient = 0.3;
      Ensemble ensemble(5, options);
      const int ticks = static_cast<int>(scaled(20000));
      const Outcome outcome = wander(ensemble, region, ticks, random);
      CHECK(outcome.worst >= -kMaxPenetration);
      CHECK(outcome.recovering == 0);
      shared += outcome.shared;
    }
  }
  if (scaled(20000) >= 2000) CHECK(shared > 1000);
}

}  // namespace hapticd::test
