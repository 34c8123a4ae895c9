// Lofting, revolving, spheres of even triangles.
#include "server/model/shapes/mesh_building.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/server/model/shapes/mesh_measures.h"
#include "tests/server/model/shapes/relative.h"

namespace hapticd::test {
namespace {

Loop square(double half, double z) {
  return {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
}

}  // namespace

TEST_CASE("two squares loft to a box facing outwards") {
  const TriangleMesh mesh = loft(std::array{square(0.5, 0.0), square(0.5, 2.0)});
  const MeshMeasures measures = measure(mesh);
  CHECK(measures.closed);
  CHECK(mesh.triangles.size() == 12);
  CHECK(measures.volume == relative(2.0, 1e-9));
  CHECK(measures.area == relative(10.0, 1e-9));
}

TEST_CASE("a loop that shrinks to a point makes a pyramid without flat triangles") {
  const TriangleMesh mesh = loft(std::array{square(0.5, 0.0), square(0.0, 3.0)});
  const MeshMeasures measures = measure(mesh);
  CHECK(measures.closed);
  CHECK(mesh.vertices.size() == 5);
  CHECK(mesh.triangles.size() == 6);
  CHECK(measures.volume == relative(1.0, 1e-9));
}

TEST_CASE("loops of different size, or too few, are refused") {
  Loop triangle = square(1.0, 1.0);
  triangle.pop_back();
  CHECK_THROWS_AS(static_cast<void>(loft(std::array{square(1.0, 0.0), triangle})),
                  std::invalid_argument);
  CHECK_THROWS_AS(static_cast<void>(loft(std::array{square(1.0, 0.0)})), std::invalid_argument);
}

TEST_CASE("a revolved cone has its volume, and its axis is y") {
  const std::array<CurvePoint, 3> profile{{{0.0, 0.0, 0, 0}, {1.0, 0.0, 0, 0}, {0.0, 3.0, 0, 0}}};
  const TriangleMesh mesh = revolve(profile, 400);
  const MeshMeasures measures = measure(mesh);
  CHECK(measures.closed);
  CHECK(static_cast<double>(measures.volume) == relative(std::numbers::pi, 1e-4));
  CHECK(measures.high.y() == 3.0);
}

TEST_CASE("a geodesic sphere has 20 f^2 triangles of about the same size on the unit sphere") {
  for (const int frequency : {1, 2, 3, 7, 20}) {
    const TriangleMesh mesh = geodesic_sphere(frequency);
    const MeshMeasures measures = measure(mesh);
    CHECK(mesh.triangles.size() == static_cast<std::size_t>(20 * frequency * frequency));
    CHECK(measures.closed);
    CHECK(measures.euler == 2);
    CHECK(measures.volume > 0.0L);
    CHECK(measures.flattest > 0.5L);
    for (const Vector3& p : mesh.vertices) REQUIRE(std::fabs(p.norm() - 1.0) < 1e-15);
  }
}

TEST_CASE("quarters of a circle join without a gap in any bit") {
  std::vector<CurvePoint> circle;
  for (int quarter = 0; quarter < 4; ++quarter) add_quarter(circle, {0.3, -0.7, 0.11, quarter}, 5);
  for (std::size_t i = 5; i < circle.size(); i += 6) {
    const CurvePoint& end = circle[i];
    const CurvePoint& begin = circle[(i + 1) % circle.size()];
    CHECK(end.u == begin.u);
    CHECK(end.v == begin.v);
  }
}

TEST_CASE("a mirrored mesh keeps its volume and faces outwards") {
  TriangleMesh mesh = geodesic_sphere(3);
  move(mesh, Matrix3::Identity(), {5.0, 1.0, 0.0});
  const TriangleMesh mirror = mirrored(mesh);
  CHECK(measure(mirror).volume == measure(mesh).volume);
  CHECK(measure(mirror).high.x() == -measure(mesh).low.x());
}

TEST_CASE("moving turns by the matrix and shifts, appending keeps both parts") {
  TriangleMesh mesh = loft(std::array{square(0.5, 0.0), square(0.5, 2.0)});
  Matrix3 R = Matrix3::Zero();  // x to y, y to z, z to x
  R(1, 0) = R(2, 1) = R(0, 2) = 1.0;
  TriangleMesh moved = mesh;
  move(moved, R, {10.0, 0.0, 0.0});
  CHECK((measure(moved).low - Vector3(10.0, -0.5, -0.5)).norm() == 0.0);
  CHECK((measure(moved).high - Vector3(12.0, 0.5, 0.5)).norm() == 0.0);
  append(mesh, moved);
  CHECK(measure(mesh).pieces == 2);
  CHECK(measure(mesh).volume == relative(4.0, 1e-9));
}

}  // namespace hapticd::test
