// Distances to meshes against exhaustive search in long double, winding numbers and closed forms.
#include "server/model/packing/mesh_distance.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/server/model/packing/test_meshes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd {
namespace {

using test::SplitMix64;

Vector3 random_point(SplitMix64& random, double half) {
  return {random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half)};
}

/// A star with spikes and saddles: vertices at random distances from the origin.
TriangleMesh spiky_mesh(std::uint64_t seed) {
  SplitMix64 random(seed);
  return test::cube_sphere(
      3, [&](const Vector3& u) { return Vector3(random.uniform(0.25, 1.25) * u); });
}

/// Signed distance to the box with corners at +-half.
double box_distance(const Vector3& half, const Vector3& p) {
  const Vector3 q = p.cwiseAbs() - half;
  const double out = std::sqrt(q.cwiseMax(0.0).squaredNorm());
  return out > 0.0 ? out : q.maxCoeff();
}

TEST_CASE("distance to a mesh is that of an exhaustive search over its triangles") {
  SplitMix64 random(401);
  for (const TriangleMesh& mesh :
       {test::blob_mesh(7), test::ellipsoid_mesh(5, {3.0, 1.0, 0.01}), test::box_mesh({1, 2, 3})}) {
    const MeshDistance distance(mesh);
    for (std::int64_t i = 0; i < test::scaled(4000); ++i) {
      const Vector3 p = random_point(random, i % 2 == 0 ? 1.2 : 5.0);
      const NearestPoint nearest = distance.nearest(p);
      const auto truth = static_cast<double>(test::exhaustive_distance(mesh, p));
      REQUIRE(std::abs(nearest.distance - truth) < 1e-14);
      REQUIRE(distance.nearest_by_exhaustion(p).distance == nearest.distance);
      REQUIRE(std::abs((p - nearest.p).norm() - truth) < 1e-14);
      REQUIRE(static_cast<double>(test::exhaustive_distance(mesh, nearest.p)) < 1e-14);
    }
  }
}

TEST_CASE("distance to a mesh is negative exactly where the mesh winds around the point") {
  SplitMix64 random(402);
  for (const TriangleMesh& mesh : {test::blob_mesh(6), test::ellipsoid_mesh(5, {1.0, 1.0, 0.05}),
                                   spiky_mesh(1), spiky_mesh(2), spiky_mesh(3)}) {
    const MeshDistance distance(mesh);
    for (std::int64_t i = 0; i < test::scaled(20'000); ++i) {
      const Vector3 p = random_point(random, 1.3);
      const double signed_distance = distance.signed_distance(p);
      if (std::fabs(signed_distance) < 1e-9) continue;
      REQUIRE((signed_distance < 0.0) == (test::winding_number(mesh, p) > 0.5L));
    }
  }
}

TEST_CASE("signed distance to a cube is the closed form near faces, edges and corners") {
  SplitMix64 random(403);
  const Vector3 half(1.0, 0.7, 0.4);
  const MeshDistance distance(test::box_mesh(half));
  for (std::int64_t i = 0; i < test::scaled(20000); ++i) {
    Vector3 p = random_point(random, 1.0).cwiseProduct(half);
    // Onto a face, an edge or a corner, then off it by 1 um to 0.1 m.
    const std::uint64_t pinned = 1 + random.below(7);
    for (unsigned k = 0; k < 3; ++k) {
      if ((pinned >> k & 1U) != 0) p[k] = p[k] < 0.0 ? -half[k] : half[k];
    }
    p += random.uniform(1e-6, 0.1) * random_point(random, 1.0);
    REQUIRE(distance.signed_distance(p) == test::within(box_distance(half, p), 1e-10));
  }
}

TEST_CASE("distance to a finely divided sphere approaches the sphere's") {
  SplitMix64 random(404);
  const int n = 24;
  const MeshDistance distance(test::ellipsoid_mesh(n, {1.0, 1.0, 1.0}));
  // The largest triangle has sides of about pi / (2 n) sqrt(2); its sagitta is below 1 - cos.
  const double sagitta = 1.0 - std::cos(1.5 / n);
  for (std::int64_t i = 0; i < test::scaled(5000); ++i) {
    const Vector3 p = random_point(random, 2.0);
    const double truth = p.norm() - 1.0;
    const double found = distance.signed_distance(p);
    REQUIRE(found >= truth - 1e-12);
    REQUIRE(found <= truth + sagitta);
  }
}

TEST_CASE("of equally near triangles the lowest is named") {
  const TriangleMesh mesh = test::box_mesh({1.0, 1.0, 1.0});
  const MeshDistance distance(mesh);
  for (const Vector3& vertex : mesh.vertices) {
    std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (const std::int32_t v : mesh.triangles[i]) {
        if (mesh.vertices[static_cast<std::size_t>(v)] == vertex) {
          lowest = std::min(lowest, static_cast<std::int32_t>(i));
        }
      }
    }
    CHECK(distance.nearest(2.0 * vertex).triangle == lowest);
  }
}

TEST_CASE("triangles without area are no obstacle to distances") {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {0, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 4}};
  const MeshDistance distance(mesh);
  CHECK(distance.nearest({0.25, 0, 0.5}).distance == doctest::Approx(0.5));
  CHECK(distance.nearest({0, 2, 0}).distance == doctest::Approx(1.0));
  CHECK(distance.nearest({2, 0, 0}).distance == doctest::Approx(1.0));
}

TEST_CASE("meshes that have no distance are refused") {
  TriangleMesh mesh;
  CHECK_THROWS_AS(MeshDistance{mesh}, std::invalid_argument);
  mesh = test::box_mesh({1, 1, 1});
  mesh.triangles[3][1] = 8;
  CHECK_THROWS_AS(MeshDistance{mesh}, std::invalid_argument);
  mesh.triangles[3][1] = -1;
  CHECK_THROWS_AS(MeshDistance{mesh}, std::invalid_argument);
  mesh = test::box_mesh({1, 1, 1});
  mesh.vertices[2].y() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(MeshDistance{mesh}, std::invalid_argument);
}

}  // namespace
}  // namespace hapticd
