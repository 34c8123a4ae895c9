// Queries that stop at a coarser level of either tree: exactly what an exhaustive search over the
// bounds of that level finds, hence never a gap larger than the true one, and fatter by no more
// than the bounds are.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// The spheres a query takes for the surface.
struct Surface {
  std::vector<Sphere> spheres;
  std::vector<TreeSphereId> ids;
  double fatness = 0.0;  ///< largest distance of a sphere's surface from its leaves', m
};

/// Least fattening of any of `leaves` by `bound`.
double slack_of(const Sphere& bound, const SphereTreeView& tree,
                const std::vector<std::int32_t>& leaves) {
  double slack = std::numeric_limits<double>::infinity();
  for (const std::int32_t i : leaves) {
    const Sphere leaf = tree.leaf(i);
    slack = std::min(slack, bound.r + (leaf.p - bound.p).norm() - leaf.r);
  }
  return slack;
}

/// Level of every node, 1 = root. Children come after their parents.
std::vector<int> node_levels(const SphereTreeView& tree) {
  std::vector<int> levels(tree.nodes.size(), 1);
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    for (const std::int32_t child : tree.nodes[n].child) {
      if (child >= 0) levels[static_cast<std::size_t>(child)] = levels[n] + 1;
    }
  }
  return levels;
}

/// Leaves below every node.
std::vector<std::vector<std::int32_t>> leaves_below(const SphereTreeView& tree) {
  std::vector<std::vector<std::int32_t>> below(tree.nodes.size());
  for (std::size_t n = tree.nodes.size(); n-- > 0;) {
    for (const std::int32_t child : tree.nodes[n].child) {
      if (child >= 0) {
        const auto& leaves = below[static_cast<std::size_t>(child)];
        below[n].insert(below[n].end(), leaves.begin(), leaves.end());
      } else if (child != kNoChild) {
        below[n].push_back(~child);
      }
    }
  }
  return below;
}

/// Reads the surface at `level` off the nodes alone: a leaf above it, a bound at it.
Surface surface_at(const SphereTreeView& tree, int level) {
  const std::vector<int> levels = node_levels(tree);
  const auto below = leaves_below(tree);
  Surface surface;
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const SphereTreeNode& node = tree.nodes[n];
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      const std::int32_t child = node.child[k];
      const bool in_reach = child < 0 ? levels[n] <= level : levels[n] == level;
      if (child == kNoChild || !in_reach) continue;
      surface.spheres.push_back({{node.x[k], node.y[k], node.z[k]}, node.r[k]});
      if (child < 0) {
        surface.ids.push_back(~child);
        continue;
      }
      surface.ids.push_back(bound_id(static_cast<std::int32_t>(n), static_cast<int>(k)));
      const auto& leaves = below[static_cast<std::size_t>(child)];
      surface.fatness = std::max(surface.fatness, slack_of(surface.spheres.back(), tree, leaves));
    }
  }
  return surface;
}

/// A scene and its surfaces at the levels of a query.
struct CoarseTruth {
  Surface tool;
  std::deque<Surface> bodies;
  std::vector<OracleBody> oracle_bodies;
  double fatness;

  CoarseTruth(const CheckedScene& scene, const QueryOptions& options)
      : tool(surface_at(scene.tool(), options.tool_level)), fatness(0.0) {
    for (const BodyView& body : scene.obstacles().bodies) {
      bodies.push_back(surface_at(body.tree, options.body_level));
      oracle_bodies.push_back({bodies.back().spheres, body.X_WB});
      fatness = std::max(fatness, bodies.back().fatness);
    }
    fatness += tool.fatness;
  }

  /// Exhaustive search over the surfaces, with the ids a query gives them.
  [[nodiscard]] OracleResult pairs(const CheckedScene& scene, const Pose& X_WG,
                                   long double margin) const {
    OracleResult result =
        exhaustive_contacts(tool.spheres, X_WG, {scene.capsules, oracle_bodies}, margin);
    for (OracleContact& pair : result.contacts) {
      ContactKey& key = pair.key;
      key.tool_sphere = tool.ids[static_cast<std::size_t>(key.tool_sphere)];
      if (key.kind == ObstacleKind::kBody) {
        key.obstacle_sphere = bodies[static_cast<std::size_t>(key.obstacle)]
                                  .ids[static_cast<std::size_t>(key.obstacle_sphere)];
      }
    }
    return result;
  }
};

QueryOptions with_levels(double margin, int tool_level, int body_level) {
  QueryOptions options;
  options.margin = margin;
  options.tool_level = tool_level;
  options.body_level = body_level;
  return options;
}

SceneParts deep_parts(SplitMix64& random) {
  SceneParts parts = random_parts(random);
  parts.tool_G = blob_spheres(50 + static_cast<int>(random.below(600)));
  parts.bodies.front().spheres_B = blob_spheres(1 + static_cast<int>(random.below(700)));
  parts.X_WG.p += 0.15 * to_vector(random.direction());
  return parts;
}

}  // namespace

TEST_CASE("a query at any two levels finds what exhaustive search over their spheres finds") {
  SplitMix64 random(1);
  for (std::int64_t trial = 0; trial < scaled(300); ++trial) {
    const SceneParts parts = deep_parts(random);
    const CheckedScene scene(parts);
    for (const int tool_level : {1, 2, 3, 4, kLeafLevel}) {
      for (const int body_level : {1, 2, 3, kLeafLevel}) {
        const QueryOptions options = with_levels(2e-3, tool_level, body_level);
        const double tolerance = kRoundingTolerance * scene.extent(parts.X_WG);
        const CoarseTruth truth(scene, options);
        const OracleResult pairs = truth.pairs(scene, parts.X_WG, options.margin + tolerance);
        if (pairs.contacts.size() > kMaxCandidates) continue;
        CAPTURE(tool_level);
        CAPTURE(body_level);
        check_set(*found_contacts(scene, parts.X_WG, options), pairs, options, tolerance);
      }
    }
  }
}

TEST_CASE("a coarse query never reports more room than there is, nor less by more than its slack") {
  SplitMix64 random(2);
  int fatter = 0;
  for (std::int64_t trial = 0; trial < scaled(1'000); ++trial) {
    SceneParts parts = deep_parts(random);
    parts.X_WG.p += random_vector(random, trial % 2 == 0 ? 0.0 : 1.0);
    const CheckedScene scene(parts);
    const auto true_gap = static_cast<double>(
        exhaustive_minimum_gap(scene.tool_spheres(), parts.X_WG, scene.oracle_obstacles()));
    const double tolerance = kRoundingTolerance * scene.extent(parts.X_WG);
    for (const int tool_level : {1, 2, 3, kLeafLevel}) {
      for (const int body_level : {1, 2, 3, kLeafLevel}) {
        const QueryOptions options = with_levels(1e-3, tool_level, body_level);
        const double gap = found_contacts(scene, parts.X_WG, options)->minimum_gap;
        REQUIRE(gap <= true_gap + tolerance);
        REQUIRE(gap >= true_gap - CoarseTruth(scene, options).fatness - tolerance);
        fatter += static_cast<int>(gap < true_gap - tolerance);
      }
    }
  }
  CHECK(fatter > 0);
}

TEST_CASE("a level below all leaves is the leaves, to the bit") {
  SplitMix64 random(3);
  for (std::int64_t trial = 0; trial < scaled(200); ++trial) {
    const SceneParts parts = deep_parts(random);
    const CheckedScene scene(parts);
    const auto leaves = found_contacts(scene, parts.X_WG, {});
    const auto deep = found_contacts(scene, parts.X_WG, with_levels(5e-3, 4, 5));
    REQUIRE(deep->contacts.size() == leaves->contacts.size());
    CHECK(deep->minimum_gap == leaves->minimum_gap);
    for (std::size_t i = 0; i < leaves->contacts.size(); ++i)
      CHECK(same_bits(deep->contacts[i], leaves->contacts[i]));
  }
}

TEST_CASE("ids of a coarse query name the bounds whose gap was taken") {
  SplitMix64 random(4);
  int bounds = 0;
  for (std::int64_t trial = 0; trial < scaled(200) + 5; ++trial) {
    const SceneParts parts = deep_parts(random);
    const CheckedScene scene(parts);
    const ObstaclesView obstacles = scene.obstacles();
    const auto set = found_contacts(scene, parts.X_WG, with_levels(2e-3, 1, 2));
    const double tolerance = 4.0 * kRoundingTolerance * scene.extent(parts.X_WG);
    for (const Contact& contact : set->contacts) {
      if (contact.key.kind != ObstacleKind::kBody) continue;
      const BodyView& body = obstacles.bodies[static_cast<std::size_t>(contact.key.obstacle)];
      const Sphere tool = tree_sphere(scene.tool(), contact.key.tool_sphere);
      const Sphere other = tree_sphere(body.tree, contact.key.obstacle_sphere);
      const double distance =
          (transform(parts.X_WG, tool.p) - transform(body.X_WB, other.p)).norm();
      REQUIRE(std::abs(contact.gap - (distance - tool.r - other.r)) <= tolerance);
      bounds += static_cast<int>(contact.key.tool_sphere < 0 && contact.key.obstacle_sphere < 0);
    }
  }
  CHECK(bounds > 10);
}

}  // namespace hapticd::test
