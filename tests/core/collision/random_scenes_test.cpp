// find_contacts against exhaustive search on random scenes: every pair, every number, the minimum
// gap. Set equality is checked with the tolerance of double rounding at the margin only.
#include <doctest/doctest.h>

#include <algorithm>

#include "core/collision/query.h"
#include "core/modeling/sphere_tree.h"
#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

TEST_CASE("every pair nearer than the margin and the true minimum gap are found in random scenes") {
  SplitMix64 random(11);
  for (std::int64_t trial = 0; trial < scaled(20000); ++trial) {
    CheckedScene scene;
    const double size = random.uniform(0.01, 0.3);
    scene.set_tool(
        random_cluster(random, 1 + static_cast<int>(random.below(120)), size, 0.0, 0.02));
    for (std::uint64_t k = random.below(8); k > 0; --k) {
      scene.capsules.push_back(
          {random_vector(random, 0.5), random_vector(random, 0.5), random.uniform(0.0, 0.01)});
    }
    for (std::uint64_t k = random.below(3); k > 0; --k) {
      const int count = 1 + static_cast<int>(random.below(300));
      scene.add_body(random_cluster(random, count, random.uniform(0.01, 0.5), 0.0, 0.02),
                     {random_rotation(random), random_vector(random, 0.5)});
    }
    QueryOptions options;
    options.margin = random.uniform(1e-4, 0.03);
    check_against_oracle(scene, {random_rotation(random), random_vector(random, 0.6)}, options);
  }
}

}  // namespace
}  // namespace hapticd::test
