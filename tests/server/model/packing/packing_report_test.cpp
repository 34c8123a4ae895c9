// Reports on spheres whose distances to a box are known in closed form.
#include "server/model/packing/packing_report.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/server/model/packing/test_meshes.h"
#include "tests/support/within.h"

namespace hapticd {
namespace {

const TriangleMesh& cube() {
  static const TriangleMesh mesh = test::box_mesh({1.0, 1.0, 1.0});
  return mesh;
}

PackingReport report(std::span<const Sphere> spheres, const ReportOptions& options = {}) {
  return report_packing(cube(), MeshDistance(cube()), spheres, options);
}

TEST_CASE("a ball around a cube is reported as in closed form") {
  const double r = std::sqrt(3.0);
  const std::array<Sphere, 1> ball{{{{0.0, 0.0, 0.0}, r + 1e-9}}};
  const PackingReport found = report(ball);
  CHECK(found.uncovered == 0.0);
  CHECK(found.inside.max == 0.0);
  CHECK(found.diagonal == doctest::Approx(2.0 * r));
  CHECK(found.mesh_samples == 200'008);
  CHECK(found.sphere_samples == 200'000);
  // Farthest in the middle of the faces; the mean over the sphere by a fine sum over z and angle.
  CHECK(found.outside.max == test::within(r - 1.0, 0.001));
  double sum = 0.0;
  const int n = 1000;
  for (int i = 0; i < n; ++i) {
    const double z = r * ((i + 0.5) / n);
    for (int j = 0; j < n; ++j) {
      const double angle = std::numbers::pi / 2.0 * (j + 0.5) / n;
      const double around = std::sqrt(r * r - z * z);
      const Vector3 p(around * std::cos(angle), around * std::sin(angle), z);
      sum += (p.array() - 1.0).max(0.0).matrix().norm();
    }
  }
  CHECK(found.outside.mean == test::within(sum / n / n, 0.01));
}

TEST_CASE("a ball in a cube leaves uncovered what is outside its discs") {
  const double r = 1.2;
  const std::array<Sphere, 1> ball{{{{0.0, 0.0, 0.0}, r}}};
  const PackingReport found = report(ball);
  // On every face a disc of radius sqrt(r^2 - 1), which fits.
  const double covered = std::numbers::pi * (r * r - 1.0) / 4.0;
  CHECK(found.uncovered == test::within(1.0 - covered, 0.01));
  CHECK(found.inside.max == test::within(std::sqrt(3.0) - r, 1e-12));
  CHECK(found.outside.max == test::within(r - 1.0, 0.001));
  // Caps have their heights above the plane spread evenly: mean half, percentiles linear.
  CHECK(found.outside.mean == test::within(0.1, 0.01));
  CHECK(found.outside.p99 == test::within(0.198, 0.005));
  CHECK(found.scallop == test::within(0.98 * 0.2, 0.01));
}

TEST_CASE("what is hidden in another sphere is not on the surface") {
  const std::array<Sphere, 2> balls{{{{0.0, 0.0, 0.0}, 1.5}, {{0.1, 0.0, 0.0}, 1.35}}};
  const std::array<Sphere, 1> alone{{{{0.0, 0.0, 0.0}, 1.5}}};
  const PackingReport two = report(balls);
  CHECK(two.outside.max == test::within(0.5, 0.001));
  CHECK(two.outside.mean == test::within(report(alone).outside.mean, 0.01));
}

TEST_CASE("a sphere given twice is seen once or twice but not hidden") {
  const std::array<Sphere, 2> twins{{{{0.0, 0.0, 0.0}, 1.5}, {{0.0, 0.0, 0.0}, 1.5}}};
  const std::array<Sphere, 1> alone{{{{0.0, 0.0, 0.0}, 1.5}}};
  CHECK(report(twins).outside.mean == test::within(report(alone).outside.mean, 0.01));
}

TEST_CASE("spheres inside the solid have nothing outside") {
  const std::array<Sphere, 1> ball{{{{0.1, 0.0, 0.0}, 0.5}}};
  const PackingReport found = report(ball);
  CHECK(found.outside.max == 0.0);
  CHECK(found.outside.mean == 0.0);
  CHECK(found.uncovered == 1.0);
  CHECK(found.inside.max == doctest::Approx(std::sqrt(1.21 + 2.0) - 0.5));
}

TEST_CASE("reports are the same with any number of threads") {
  const std::array<Sphere, 2> balls{{{{0.3, 0.0, 0.2}, 1.1}, {{-0.2, 0.1, 0.0}, 1.2}}};
  ReportOptions options;
  options.samples = 20'000;
  const PackingReport one = report(balls, options);
  for (const int threads : {2, 5}) {
    options.threads = threads;
    const PackingReport many = report(balls, options);
    CHECK(many.outside.mean == one.outside.mean);
    CHECK(many.outside.p99 == one.outside.p99);
    CHECK(many.outside.max == one.outside.max);
    CHECK(many.inside.mean == one.inside.mean);
    CHECK(many.uncovered == one.uncovered);
  }
}

TEST_CASE("reports without spheres or samples are refused") {
  const std::array<Sphere, 1> ball{{{{0.0, 0.0, 0.0}, 1.0}}};
  CHECK_THROWS_AS(report({}), std::invalid_argument);
  CHECK_THROWS_AS(report(ball, {0, 1, 1}), std::invalid_argument);
  CHECK_THROWS_AS(report(ball, {10, 1, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace hapticd
