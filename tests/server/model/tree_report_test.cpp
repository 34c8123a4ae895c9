// Levels of a tree and what is said of them. Truth: a ball whose spheres are known, the spheres
// themselves in an exhaustive search.
#include "server/model/tree_report.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "tests/core/tree/sphere_families.h"
#include "tests/server/model/packing/test_meshes.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

std::vector<Sphere> cloud(int count) { return sphere_families(count, 3).front().spheres; }

}  // namespace

TEST_CASE("the last level is the leaves, and every level covers them all") {
  for (const int count : {1, 5, 8, 9, 70, 600}) {
    const std::vector<Sphere> spheres = cloud(count);
    const SphereTree tree = build_sphere_tree(spheres);
    const std::vector<std::int32_t> counts = spheres_per_level(tree);
    REQUIRE(counts.size() == static_cast<std::size_t>(tree.depth));
    CHECK(counts.back() == static_cast<std::int32_t>(spheres.size()));
    for (int level = 1; level <= tree.depth; ++level) {
      const std::vector<Sphere> bounds = level_spheres(tree, level);
      CAPTURE(level);
      CHECK(static_cast<std::int32_t>(bounds.size()) ==
            counts[static_cast<std::size_t>(level - 1)]);
      for (const Sphere& leaf : spheres) {
        REQUIRE(std::any_of(bounds.begin(), bounds.end(), [&](const Sphere& bound) {
          return (bound.p - leaf.p).norm() + leaf.r <= bound.r * (1 + 1e-12);
        }));
      }
    }
  }
}

TEST_CASE("no point of a sphere is further outside than its bound") {
  SplitMix64 random(2);
  const TriangleMesh mesh = blob_mesh(8);
  const MeshDistance distance(mesh);
  for (int trial = 0; trial < 50; ++trial) {
    const auto direction = random.direction();
    const Sphere sphere{to_vector(direction) * random.uniform(0.0, 2.0), random.uniform(0.0, 1.0)};
    const double bound = outer_bound(distance, std::vector<Sphere>{sphere});
    for (int k = 0; k < 200; ++k) {
      const Vector3 p = sphere.p + sphere.r * to_vector(random.direction());
      REQUIRE(distance.signed_distance(p) <= bound + 1e-12);
    }
  }
}

TEST_CASE("reports name the spheres, the levels and what is known of the build") {
  MeasuredTree file;
  file.tree = build_sphere_tree(cloud(20));
  file.source_name = "a \"mesh\".obj";
  for (const std::int32_t n : spheres_per_level(file.tree)) file.levels.push_back({n, 0.02, 0.01});
  TreeReport report;
  report.name = "x.tree";
  report.file = &file;
  CHECK(to_markdown(report).find("measured") == std::string::npos);
  CHECK(to_markdown(report).find("built in") == std::string::npos);
  report.has_packing = true;
  report.packing.diagonal = 0.5;
  report.packing.outside = {0.005, 0.001, 0.004};
  report.seconds = 1.5;
  report.threads = 2;
  const std::string text = to_markdown(report);
  CHECK(text.find("max 5 mm (1 %), mean 1 mm (0.2 %), p99 4 mm (0.8 %)") != std::string::npos);
  CHECK(text.find("built in | 1.5 s on 2 threads") != std::string::npos);
  CHECK(text.find("(leaves)") != std::string::npos);
  report.levels = 1;
  CHECK(to_markdown(report).find("(leaves)") == std::string::npos);
  const std::string json = to_json(report);
  CHECK(json.find("\"source\":\"a \\\"mesh\\\".obj\"") != std::string::npos);
  CHECK(json.find("\"outside\":{\"max\":0.005,\"mean\":0.001,\"p99\":0.004}") != std::string::npos);
  CHECK(std::count(json.begin(), json.end(), '\n') == 1);
  CHECK(std::count(json.begin(), json.end(), '{') == std::count(json.begin(), json.end(), '}'));
}

}  // namespace hapticd::test
