// The bound of a set of spheres: contains them all in exact arithmetic, and is close to the
// smallest where that is known. Truth: long double, closed forms.
#include "core/tree/enclosing_sphere.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tests/core/tree/sphere_families.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// A bound is allowed to be this much larger than the smallest one.
constexpr double kLooseness = 1.01;

Sphere enclose(const std::vector<Sphere>& spheres) {
  std::vector<std::int32_t> members(spheres.size());
  std::iota(members.begin(), members.end(), 0);
  return enclosing_sphere(spheres, members);
}

/// Distance the worst sphere sticks out of `bound`, m; <= 0 when all are inside.
long double sticks_out(const std::vector<Sphere>& spheres, const Sphere& bound) {
  long double worst = -std::numeric_limits<long double>::infinity();
  for (const Sphere& sphere : spheres) {
    long double square = 0;
    for (int k = 0; k < 3; ++k) {
      const long double part = static_cast<long double>(sphere.p[k]) - bound.p[k];
      square += part * part;
    }
    worst = std::max(worst, std::sqrt(square) + sphere.r - bound.r);
  }
  return worst;
}

/// `bound` holds all of `spheres` and is at most kLooseness times `smallest`.
void check_bound(const std::vector<Sphere>& spheres, double smallest) {
  const Sphere bound = enclose(spheres);
  CHECK(sticks_out(spheres, bound) <= 0.0L);
  CHECK(bound.r >= smallest * (1.0 - 1e-15));
  CHECK(bound.r <= smallest * kLooseness);
}

std::vector<Sphere> points(const std::vector<Vector3>& centres) {
  std::vector<Sphere> spheres;
  spheres.reserve(centres.size());
  for (const Vector3& p : centres) spheres.push_back({p, 0.0});
  return spheres;
}

}  // namespace

TEST_CASE("every family of spheres lies inside its bound, in any unit and far from the origin") {
  for (std::int64_t seed = 0; seed < scaled(50); ++seed) {
    for (const SphereFamily& family : sphere_families(60, static_cast<std::uint64_t>(seed))) {
      CAPTURE(family.name);
      for (const double unit : {1e-100, 1e-6, 1.0, 1e3, 1e6, 1e100}) {
        for (const double far : {0.0, 1.0, 1e6, 1e12}) {
          const Vector3 p = far * unit * Vector3(1.0, -0.7, 0.3);
          const auto spheres = scaled_and_moved(family.spheres, unit, p);
          CAPTURE(unit);
          CAPTURE(far);
          REQUIRE(sticks_out(spheres, enclose(spheres)) <= 0.0L);
        }
      }
    }
  }
}

TEST_CASE("one sphere is its own bound") {
  const Sphere sphere{{0.1, -0.2, 1e3}, 0.05};
  const Sphere bound = enclose({sphere});
  CHECK(bound.p == sphere.p);
  CHECK(bound.r == sphere.r);
}

TEST_CASE("only members are enclosed") {
  const std::vector<Sphere> spheres{
      {{0, 0, 0}, 1.0}, {{1e6, 0, 0}, 1.0}, {{2, 0, 0}, 1.0}, {{0, -1e6, 0}, 5.0}};
  const std::vector<std::int32_t> members{0, 2};
  const Sphere bound = enclosing_sphere(spheres, members);
  CHECK((bound.p - Vector3(1, 0, 0)).norm() <= 0.05);
  CHECK(bound.r <= 2.0 * kLooseness);
}

TEST_CASE("two points are bound by the sphere over their distance") {
  SplitMix64 random(1);
  for (std::int64_t i = 0; i < scaled(10'000); ++i) {
    const Vector3 a = random_vector(random, 1.0);
    const Vector3 b = random_vector(random, 1.0);
    check_bound(points({a, b}), 0.5 * (a - b).norm());
  }
}

TEST_CASE("two spheres are bound by half the way over both") {
  SplitMix64 random(2);
  for (std::int64_t i = 0; i < scaled(10'000); ++i) {
    const Sphere a{random_vector(random, 1.0), random.uniform(0.0, 1.0)};
    const Sphere b{random_vector(random, 1.0), random.uniform(0.0, 1.0)};
    const double d = (a.p - b.p).norm();
    const double smallest = std::max({a.r, b.r, 0.5 * (d + a.r + b.r)});
    check_bound({a, b}, smallest);
  }
}

TEST_CASE("the corners of a cube, a regular simplex and triangles have bounds near the smallest") {
  const double a = 0.7;
  std::vector<Vector3> cube;
  cube.reserve(8);
  for (int i = 0; i < 8; ++i)
    cube.push_back({i % 2 != 0 ? a : 0.0, i / 2 % 2 != 0 ? a : 0.0, i / 4 != 0 ? a : 0.0});
  check_bound(points(cube), 0.5 * std::sqrt(3.0) * a);
  check_bound(points({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}), std::sqrt(3.0));
  // Equilateral: the circumcircle. Right and obtuse: half the longest side.
  check_bound(points({{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}}), std::sqrt(1.0 / 3.0));
  check_bound(points({{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}), 2.5);
  check_bound(points({{0, 0, 0}, {10, 0, 0}, {5, 0.1, 0}}), 5.0);
}

TEST_CASE("spheres that touch a sphere at two opposite points are bound by little more than it") {
  SplitMix64 random(3);
  for (std::int64_t trial = 0; trial < scaled(2'000); ++trial) {
    const Vector3 centre = random_vector(random, 1.0);
    const double R = random.uniform(0.1, 2.0);
    const Vector3 way = to_vector(random.direction());
    std::vector<Sphere> spheres;
    for (int i = 0; i < 40; ++i) {
      // Each touches the big sphere from inside; the first two opposite each other.
      const double r = random.uniform(0.0, 0.5 * R);
      const Vector3 d =
          i < 2 ? Vector3(i == 0 ? way : Vector3(-way)) : to_vector(random.direction());
      spheres.push_back({centre + (R - r) * d, r});
    }
    check_bound(spheres, R);
  }
}

TEST_CASE("a sphere that contains all others is nearly the bound itself") {
  std::vector<Sphere> spheres{{{0.3, 0.2, 0.1}, 1.0}};
  SplitMix64 random(4);
  for (int i = 0; i < 50; ++i) {
    spheres.push_back({spheres[0].p + random_vector(random, 0.4), random.uniform(0.0, 0.2)});
  }
  check_bound(spheres, 1.0);
}

TEST_CASE("coincident spheres of many sizes are bound by the largest, points by next to nothing") {
  const Vector3 p(1e3, -2.0, 0.1);
  check_bound({{p, 0.1}, {p, 0.5}, {p, 0.0}, {p, 0.3}}, 0.5);
  const Sphere bound = enclose({{p, 0.0}, {p, 0.0}, {p, 0.0}});
  CHECK((bound.p - p).norm() <= 1e-12);
  CHECK(bound.r <= 1e-12);
}

TEST_CASE("the same spheres give the same bound to the bit") {
  for (const SphereFamily& family : sphere_families(100, 9)) {
    const Sphere a = enclose(family.spheres);
    const Sphere b = enclose(family.spheres);
    CHECK(a.p == b.p);
    CHECK(a.r == b.r);
  }
}

}  // namespace hapticd::test
