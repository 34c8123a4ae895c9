// The boxes of a body's nodes: a query finds the same with them and without, and over what is flat
// it looks at far fewer pairs.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Contacts of `tool` at `X_WG` with one body, by its boxes or by its spheres alone.
std::unique_ptr<ContactSet> query(const SphereTree& tool, const Pose& X_WG, const SphereTree& body,
                                  const Pose& X_WB, const QueryOptions& options, bool boxes) {
  BodyView view{body.view(), X_WB};
  if (!boxes) view.tree.boxes = {};
  auto out = std::make_unique<ContactSet>();
  find_contacts({tool.view(), X_WG}, {{}, {&view, 1}}, options, *out);
  return out;
}

}  // namespace

TEST_CASE("a query finds the same pairs and the same smallest gap with boxes and without") {
  SplitMix64 random(61);
  std::int64_t touching = 0;
  for (std::int64_t trial = 0; trial < scaled(5000); ++trial) {
    const SphereTree tool = build_sphere_tree(random_cluster(random, 120, 0.1, 0.0, 0.02));
    const SphereTree body = random.chance(0.5)
                                ? build_sphere_tree(random_cluster(random, 300, 0.2, 0.0, 0.02))
                                : build_sphere_tree(slab_spheres(20, 10));
    const Pose X_WG{random_rotation(random), random_vector(random, 0.3)};
    const Pose X_WB{random_rotation(random), random_vector(random, 0.3)};
    QueryOptions options;
    options.margin = random.uniform(1e-4, 0.03);
    if (random.chance(0.3)) options.tool_level = 1;
    if (random.chance(0.3)) options.body_level = 1;
    const auto with = query(tool, X_WG, body, X_WB, options, true);
    const auto without = query(tool, X_WG, body, X_WB, options, false);
    touching += with->contacts.empty() ? 0 : 1;
    REQUIRE(with->minimum_gap == without->minimum_gap);
    REQUIRE(with->covered_margin == without->covered_margin);
    const std::vector<Contact> a = by_key(*with);
    const std::vector<Contact> b = by_key(*without);
    REQUIRE(a.size() == b.size());
    for (std::size_t k = 0; k < a.size(); ++k) REQUIRE(same_bits(a[k], b[k]));
  }
  CHECK(touching > scaled(500));
}

TEST_CASE("boxes spare a hand above a sounding board three quarters of the pairs") {
  const SphereTree hand = build_sphere_tree(blob_spheres(1000));
  const SphereTree board = build_sphere_tree(slab_spheres(160, 25));
  const Pose X_WG{{1.0, 0.0, 0.0, 0.0}, {0.0, 0.052, 0.0}};
  QueryOptions options;
  options.margin = options.horizon = 1e-3;
  const auto with = query(hand, X_WG, board, {}, options, true);
  const auto without = query(hand, X_WG, board, {}, options, false);
  CHECK(with->contacts.empty());
  MESSAGE("tests with boxes " << with->tests << ", without " << without->tests);
  CHECK(4 * with->tests < without->tests);
}

TEST_CASE("a million far leaves cost one look at the box around them") {
  const auto side = static_cast<int>(std::sqrt(static_cast<double>(scaled(1'000'000))));
  const SphereTree board = build_sphere_tree(slab_spheres(side, side));
  const SphereTree finger = build_sphere_tree(std::vector<Sphere>{{{0.0, 0.0, 0.0}, 5e-3}});
  QueryOptions options;
  options.horizon = 6e-3;
  const auto found =
      query(finger, {{1.0, 0.0, 0.0, 0.0}, {0.0, 0.05, 0.0}}, board, {}, options, true);
  CHECK(found->contacts.empty());
  CHECK(found->minimum_gap == options.horizon);
  CHECK(found->tests == 0);
  const auto without =
      query(finger, {{1.0, 0.0, 0.0, 0.0}, {0.0, 0.05, 0.0}}, board, {}, options, false);
  MESSAGE(board.leaf_r.size() << " leaves: tests " << found->tests << ", without boxes "
                              << without->tests);
}

}  // namespace hapticd::test
