// Packings against what they promise: coverage and protrusion by exhaustive search over spheres and
// closed forms, and their quality on meshes of known shape.
#include "server/model/packing/sphere_packing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "server/model/packing/packing_report.h"
#include "tests/server/model/packing/test_meshes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd {
namespace {

using test::SplitMix64;

/// Gates on the blob, as shares of its diagonal: 1.2 times what was reached.
constexpr double kBlobMax = 1.2 * 0.00645;
constexpr double kBlobMean = 1.2 * 0.00386;

Packing pack(const TriangleMesh& mesh, const PackingOptions& options) {
  return pack_spheres(mesh, MeshDistance(mesh), options);
}

PackingOptions with_bound(double outer) {
  PackingOptions options;
  options.outer = outer;
  return options;
}

PackingOptions with_leaves(int leaves) {
  PackingOptions options;
  options.leaves = leaves;
  return options;
}

/// Largest distance by which a point of the surface sticks out of all spheres, of `count` random
/// points and all vertices; exhaustive.
double worst_gap(const TriangleMesh& mesh, const std::vector<Sphere>& spheres, std::int64_t count) {
  SplitMix64 random(411);
  double worst = -std::numeric_limits<double>::infinity();
  const auto look = [&](const Vector3& p) {
    double gap = std::numeric_limits<double>::infinity();
    for (const Sphere& s : spheres) gap = std::min(gap, (p - s.p).norm() - s.r);
    worst = std::max(worst, gap);
  };
  for (const Vector3& v : mesh.vertices) look(v);
  for (std::int64_t i = 0; i < count; ++i) {
    const Triangle& t = mesh.triangles[random.below(mesh.triangles.size())];
    double u = random.uniform();
    double v = random.uniform();
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    // Often on an edge of the mesh.
    if (random.chance(0.3)) v = 0.0;
    const Vector3& a = mesh.vertices[static_cast<std::size_t>(t[0])];
    look(a + u * (mesh.vertices[static_cast<std::size_t>(t[1])] - a) +
         v * (mesh.vertices[static_cast<std::size_t>(t[2])] - a));
  }
  return worst;
}

/// Largest distance outside the box with corners at +-half, of random points of the spheres.
double worst_outside_box(const Vector3& half, const std::vector<Sphere>& spheres,
                         std::int64_t per_sphere) {
  SplitMix64 random(412);
  double worst = 0.0;
  for (const Sphere& s : spheres) {
    for (std::int64_t i = 0; i < per_sphere; ++i) {
      const auto d = random.direction();
      const Vector3 p = s.p + s.r * Vector3(d[0], d[1], d[2]);
      worst = std::max(worst, (p.cwiseAbs() - half).cwiseMax(0.0).norm());
    }
  }
  return worst;
}

TEST_CASE("every point of a packed surface lies in a sphere") {
  for (const TriangleMesh& mesh : {test::blob_mesh(8), test::box_mesh({1.0, 0.6, 0.3})}) {
    const Packing packing = pack(mesh, with_bound(0.05));
    CHECK(worst_gap(mesh, packing.leaves, test::scaled(50'000)) <= 0.0);
  }
}

TEST_CASE("no sphere sticks out of a box further than the bound stated, nor that than asked") {
  const Vector3 half(1.0, 0.6, 0.3);
  const Packing packing = pack(test::box_mesh(half), with_bound(0.05));
  CHECK(packing.outer <= 0.05);
  const double worst = worst_outside_box(half, packing.leaves, test::scaled(5000));
  CHECK(worst <= packing.outer);
  CHECK(worst > 0.0);
}

TEST_CASE("no sphere sticks out of an ellipsoid further than the bound stated") {
  const Vector3 half(1.0, 0.5, 0.4);
  const Packing packing = pack(test::ellipsoid_mesh(10, half), with_bound(0.03));
  SplitMix64 random(413);
  CHECK(packing.outer <= 0.03);
  for (const Sphere& s : packing.leaves) {
    for (std::int64_t i = 0; i < test::scaled(3000); ++i) {
      const auto d = random.direction();
      const Vector3 p = s.p + s.r * Vector3(d[0], d[1], d[2]);
      // The mesh lies in the ellipsoid by up to its sagitta; a point within `outer` of the mesh is
      // within `outer` of the ellipsoid, so inside the one with half axes larger by it.
      REQUIRE(p.cwiseQuotient(half + Vector3::Constant(packing.outer)).norm() <= 1.0 + 1e-9);
    }
  }
}

TEST_CASE("with an inner margin the surface sticks out of the spheres by no more than it") {
  const TriangleMesh mesh = test::blob_mesh(8);
  PackingOptions options = with_bound(0.03);
  const std::size_t without = pack(mesh, options).leaves.size();
  options.inner = 0.03;
  const Packing packing = pack(mesh, options);
  CHECK(packing.inner == 0.03);
  CHECK(packing.outer <= 0.03);
  CHECK(packing.leaves.size() < without);
  const double gap = worst_gap(mesh, packing.leaves, test::scaled(50'000));
  CHECK(gap <= 0.03);
  CHECK(gap > 0.0);
}

TEST_CASE("packings are the same with any number of threads") {
  const TriangleMesh mesh = test::blob_mesh(4);
  for (PackingOptions options : {with_bound(0.1), with_leaves(2)}) {
    const Packing one = pack(mesh, options);
    for (const int threads : {5}) {
      options.threads = threads;
      const Packing many = pack(mesh, options);
      CHECK(many.outer == one.outer);
      REQUIRE(many.leaves.size() == one.leaves.size());
      for (std::size_t i = 0; i < one.leaves.size(); ++i) {
        REQUIRE(many.leaves[i].p == one.leaves[i].p);
        REQUIRE(many.leaves[i].r == one.leaves[i].r);
      }
    }
  }
}

TEST_CASE("a number of spheres is not exceeded, and more of them fit better") {
  const TriangleMesh mesh = test::blob_mesh(5);
  double last = std::numeric_limits<double>::infinity();
  for (const int leaves : {1, 12}) {
    const Packing packing = pack(mesh, with_leaves(leaves));
    CHECK(packing.leaves.size() <= static_cast<std::size_t>(leaves));
    CHECK(packing.outer < last);
    CHECK(worst_gap(mesh, packing.leaves, test::scaled(20'000)) <= 0.0);
    last = packing.outer;
  }
}

TEST_CASE("a sphere takes one sphere, also when many are allowed to be worse") {
  const TriangleMesh mesh = test::ellipsoid_mesh(8, {1.0, 1.0, 1.0});
  const Packing packing = pack(mesh, with_bound(0.05));
  CHECK(packing.leaves.size() == 1);
  CHECK(packing.leaves.front().p.norm() < 0.05);
  CHECK(worst_gap(mesh, packing.leaves, test::scaled(20'000)) <= 0.0);
}

TEST_CASE("a thin plate and a needle are covered within the bound") {
  const Vector3 plate(1.0, 0.3, 0.01);
  const Packing flat = pack(test::box_mesh(plate), with_bound(0.04));
  CHECK(worst_gap(test::box_mesh(plate), flat.leaves, test::scaled(20'000)) <= 0.0);
  CHECK(worst_outside_box(plate, flat.leaves, test::scaled(1000)) <= 0.04);

  TriangleMesh needle;
  needle.vertices = {{0, 0, 0}, {0.02, 0, 0}, {0, 0.02, 0}, {0, 0, 1}};
  needle.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Packing thin = pack(needle, with_bound(0.01));
  CHECK(thin.outer <= 0.01);
  CHECK(worst_gap(needle, thin.leaves, test::scaled(20'000)) <= 0.0);
}

TEST_CASE("a solid with an edge less than a right angle is covered within the bound") {
  // A wedge of 20 degrees.
  TriangleMesh wedge;
  wedge.vertices = {{0, 0, 0}, {1, 0.18, 0}, {1, -0.18, 0}, {0, 0, 1}, {1, 0.18, 1}, {1, -0.18, 1}};
  wedge.triangles = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1},
                     {1, 4, 5}, {1, 5, 2}, {2, 5, 3}, {2, 3, 0}};
  const MeshDistance distance(wedge);
  CHECK(distance.signed_distance({0.5, 0.0, 0.5}) < 0.0);
  const Packing packing = pack(wedge, with_bound(0.04));
  CHECK(packing.outer <= 0.04);
  CHECK(worst_gap(wedge, packing.leaves, test::scaled(20'000)) <= 0.0);
}

TEST_CASE("a smooth blob takes few spheres") {
  const TriangleMesh mesh = test::blob_mesh(16);
  const MeshDistance distance(mesh);
  const double diagonal = report_packing(mesh, distance, {{Sphere{}}}, {100, 1, 1}).diagonal;
  // Few of them under a sanitizer, where the quality is the same and the time is not.
  const bool full = test::test_scale() > 0.05;
  const Packing packing = pack_spheres(mesh, distance, with_leaves(full ? 40 : 2));
  ReportOptions options;
  options.samples = 20'000;
  const PackingReport report = report_packing(mesh, distance, packing.leaves, options);
  CHECK(report.uncovered == 0.0);
  CHECK(report.outside.max <= packing.outer);
  if (!full) return;
  CHECK(report.outside.max <= kBlobMax * diagonal);
  CHECK(report.outside.mean <= kBlobMean * diagonal);
}

TEST_CASE("progress rises to one") {
  const TriangleMesh mesh = test::blob_mesh(4);
  for (PackingOptions& options : std::array{with_bound(0.1), with_leaves(5)}) {
    double last = 0.0;
    bool rises = true;
    options.progress = [&](double done) {
      rises = rises && done >= last && done <= 1.0;
      last = done;
    };
    static_cast<void>(pack(mesh, options));
    CHECK(rises);
    CHECK(last == 1.0);
  }
}

TEST_CASE("packings that cannot be are refused") {
  const TriangleMesh mesh = test::box_mesh({1, 1, 1});
  CHECK_THROWS_AS(pack(mesh, with_bound(0.0)), std::invalid_argument);
  CHECK_THROWS_AS(pack(mesh, with_bound(-1.0)), std::invalid_argument);
  CHECK_THROWS_AS(pack(mesh, with_bound(std::numeric_limits<double>::quiet_NaN())),
                  std::invalid_argument);
  CHECK_THROWS_AS(pack(mesh, with_leaves(0)), std::invalid_argument);
  PackingOptions options = with_bound(0.1);
  options.inner = -0.1;
  CHECK_THROWS_AS(pack(mesh, options), std::invalid_argument);
  options.inner = 0.0;
  options.threads = 0;
  CHECK_THROWS_AS(pack(mesh, options), std::invalid_argument);
  // Far more than 2^24 spheres.
  CHECK_THROWS_AS(pack(mesh, with_bound(1e-8)), std::runtime_error);
}

}  // namespace
}  // namespace hapticd
