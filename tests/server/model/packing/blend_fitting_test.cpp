// Balls fitted so that they blend into the surface of a mesh: it is covered, and felt by a tip with
// less ripple than the union of the balls. Truth: exhaustive distances from the mesh, and phi by
// the equation that defines it, halved over all balls.
#include "server/model/packing/blend_fitting.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "server/model/packing/sphere_packing.h"
#include "tests/server/model/packing/test_meshes.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

/// A board 100 mm long and 12 mm thick, with balls that stick out by 0.5 mm at most.
constexpr double kBound = 0.5e-3;
constexpr double kWidth = 2e-3;
constexpr double kTip = 4e-3;
const Vector3 kHalf{0.05, 0.006, 0.03};

std::vector<Sphere> packed(const TriangleMesh& mesh, const MeshDistance& distance) {
  PackingOptions options;
  options.outer = kBound;
  return pack_spheres(mesh, distance, options).leaves;
}

double least_gap(const std::vector<Sphere>& leaves, const Vector3& p) {
  double least = 1e9;
  for (const Sphere& leaf : leaves) least = std::min(least, (p - leaf.p).norm() - leaf.r);
  return least;
}

double phi(const std::vector<Sphere>& leaves, const Vector3& p) {
  double high = least_gap(leaves, p);
  double low = high - kWidth;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    double sum = 0.0;
    for (const Sphere& leaf : leaves) {
      const double s = 1.0 - ((p - leaf.p).norm() - leaf.r - middle) / kWidth;
      if (s > 0.0) sum += s * s * s;
    }
    (sum > 1.0 ? high : low) = middle;
  }
  return low;
}

/// Standard deviation of what `distance_of` finds above the top of the board, m.
template <typename DistanceOf>
double ripple(const DistanceOf& distance_of) {
  SplitMix64 random(81);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kCount = 2000;
  for (int k = 0; k < kCount; ++k) {
    const double d = distance_of(
        Vector3(random.uniform(-0.03, 0.03), kHalf.y() + kTip, random.uniform(-0.015, 0.015)));
    sum += d;
    squares += d * d;
  }
  return std::sqrt(squares / kCount - sum * sum / (kCount * kCount));
}

}  // namespace

TEST_CASE("balls fitted to a board cover it, and a tip feels a third of their ripple") {
  const TriangleMesh mesh = box_mesh(kHalf);
  const MeshDistance distance(mesh);
  const std::vector<Sphere> balls = packed(mesh, distance);
  std::vector<Sphere> leaves = balls;
  const BlendFit fit = fit_blend(mesh, distance, {kWidth, kBound, 2}, leaves);
  REQUIRE(leaves.size() == balls.size());
  CHECK(fit.inner < 1e-6);
  CHECK(fit.outer < 2.0 * kBound);
  CHECK(fit.mean < kBound);
  SplitMix64 random(82);
  for (int k = 0; k < 5000; ++k) {
    Vector3 p(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const auto axis = static_cast<Eigen::Index>(random.below(3));
    p[axis] = random.chance(0.5) ? 1.0 : -1.0;
    p = p.cwiseProduct(kHalf);
    REQUIRE(phi(leaves, p) < 5e-6);
  }
  const double before = ripple([&](const Vector3& p) { return least_gap(balls, p); });
  const double after = ripple([&](const Vector3& p) { return phi(leaves, p); });
  MESSAGE("ripple ", 1e6 * before, " um, blended ", 1e6 * after, " um");
  CHECK(after < before / 3.0);
}

TEST_CASE("the fit has the same bits with any number of threads") {
  const TriangleMesh mesh = box_mesh({0.02, 0.006, 0.02});
  const MeshDistance distance(mesh);
  const std::vector<Sphere> balls = packed(mesh, distance);
  std::vector<Sphere> alone = balls;
  std::vector<Sphere> together = balls;
  const BlendFit one = fit_blend(mesh, distance, {kWidth, kBound, 1}, alone);
  const BlendFit three = fit_blend(mesh, distance, {kWidth, kBound, 3}, together);
  CHECK(one.mean == three.mean);
  CHECK(std::equal(alone.begin(), alone.end(), together.begin(), together.end(),
                   [](const Sphere& a, const Sphere& b) { return a.p == b.p && a.r == b.r; }));
}

}  // namespace hapticd::test
