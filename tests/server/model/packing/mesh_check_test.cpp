// Faults of meshes: each one is put into a sound mesh by hand and must be found, counted and
// placed; nothing else may be. Truth: the cube and what was done to it.
#include "server/model/packing/mesh_check.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "server/model/packing/mesh_crossings.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

/// A box of 12 triangles; vertex k stands at corner (bit 0, bit 1, bit 2) of k.
TriangleMesh box(const Vector3& low, const Vector3& high) {
  TriangleMesh mesh;
  for (unsigned k = 0; k < 8; ++k) {
    mesh.vertices.emplace_back((k & 1U) != 0 ? high.x() : low.x(),
                               (k & 2U) != 0 ? high.y() : low.y(),
                               (k & 4U) != 0 ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TriangleMesh cube() { return box({0.0, 0.0, 0.0}, {0.1, 0.1, 0.1}); }

void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto offset = static_cast<std::int32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles) {
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
}

void turn(Triangle& t) { std::swap(t[1], t[2]); }

/// The only finding of a mesh; nothing when there is none or there are more.
std::optional<MeshFinding> only_finding(const TriangleMesh& mesh) {
  const MeshReport report = check_mesh(mesh);
  if (report.findings.size() != 1) return std::nullopt;
  return report.findings.front();
}

void check_only(const TriangleMesh& mesh, MeshFault fault, std::int64_t count, bool is_usable) {
  const std::optional<MeshFinding> finding = only_finding(mesh);
  REQUIRE(finding.has_value());
  CHECK(finding->fault == fault);
  CHECK(finding->count == count);
  CHECK(usable(check_mesh(mesh)) == is_usable);
  CHECK(describe(*finding).size() > 20);
}

/// Whether the inside of segment ab meets the inside of the triangle: a + s (b - a) = p + u (q - p)
/// + v (r - p), solved by Cramer's rule in long double.
bool meets(const TriangleMesh& mesh, std::int32_t a, std::int32_t b, const Triangle& t) {
  using Wide = Eigen::Matrix<long double, 3, 1>;
  const auto at = [&](std::int32_t i) -> Wide {
    return mesh.vertices[static_cast<std::size_t>(i)].cast<long double>();
  };
  const Wide d = at(a) - at(b);
  const Wide pq = at(t[1]) - at(t[0]);
  const Wide pr = at(t[2]) - at(t[0]);
  const Wide pa = at(a) - at(t[0]);
  const long double det = pq.cross(pr).dot(d);
  const long double s = pq.cross(pr).dot(pa) / det;
  const long double u = pa.cross(pr).dot(d) / det;
  const long double v = pq.cross(pa).dot(d) / det;
  return s > 0 && s < 1 && u > 0 && v > 0 && u + v < 1;
}

}  // namespace

TEST_CASE("a sound cube has no finding, and the volume, area and diagonal of a cube") {
  const MeshReport report = check_mesh(cube());
  CHECK(report.findings.empty());
  CHECK(report.volume == doctest::Approx(1e-3));
  CHECK(report.area == doctest::Approx(0.06));
  CHECK(report.diagonal == doctest::Approx(0.173205081));
  CHECK(report.pieces == 1);
}

TEST_CASE("a mesh without triangles is an error") {
  check_only({}, MeshFault::kNoTriangles, 1, false);
}

TEST_CASE("an index that names no vertex is an error, whichever way it is out") {
  for (const std::int32_t bad : {8, -1, std::numeric_limits<std::int32_t>::max(),
                                 std::numeric_limits<std::int32_t>::min()}) {
    TriangleMesh mesh = cube();
    mesh.triangles[5][1] = bad;
    check_only(mesh, MeshFault::kIndexOutOfRange, 1, false);
    CHECK(only_finding(mesh)->triangle == 5);
  }
}

TEST_CASE("a coordinate that is no finite number is an error") {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    TriangleMesh mesh = cube();
    mesh.vertices[7].y() = bad;
    const auto users = std::count_if(mesh.triangles.begin(), mesh.triangles.end(), [](Triangle t) {
      return std::find(t.begin(), t.end(), 7) != t.end();
    });
    check_only(mesh, MeshFault::kNotFinite, users, false);
  }
}

TEST_CASE("a collapsed triangle is an error that repair removes") {
  TriangleMesh mesh = cube();
  mesh.triangles.push_back({3, 3, 5});
  const MeshReport report = check_mesh(mesh);
  REQUIRE(report.findings.size() >= 1);
  CHECK(report.findings.front().fault == MeshFault::kCollapsed);
  CHECK(report.findings.front().triangle == 12);
  CHECK(repair_mesh(mesh).dropped == 1);
  CHECK(check_mesh(mesh).findings.empty());
}

TEST_CASE("a triangle without area is a warning") {
  // Edge 0-1 of the cube gets a vertex in its middle, in one of its two triangles only by a flat
  // triangle.
  TriangleMesh mesh = cube();
  mesh.vertices.emplace_back(0.05, 0.0, 0.0);
  mesh.triangles[0] = {0, 2, 8};
  mesh.triangles.push_back({8, 2, 1});
  mesh.triangles.push_back({0, 8, 1});
  check_only(mesh, MeshFault::kFlat, 1, true);
}

TEST_CASE("a missing triangle leaves three open edges, and the place is one of them") {
  TriangleMesh mesh = cube();
  mesh.triangles.erase(mesh.triangles.begin());
  check_only(mesh, MeshFault::kOpenEdge, 3, false);
  CHECK(only_finding(mesh)->p.z() == 0.0);
}

TEST_CASE("an edge of four triangles is an error") {
  // Two cubes that share one edge.
  TriangleMesh mesh = cube();
  append(mesh, box({0.1, 0.1, 0.0}, {0.2, 0.2, 0.1}));
  check_only(weld(mesh), MeshFault::kCrowdedEdge, 1, false);
}

TEST_CASE("turned triangles are found and turned back") {
  TriangleMesh mesh = cube();
  turn(mesh.triangles[4]);
  check_only(mesh, MeshFault::kTurned, 3, false);
  CHECK(repair_mesh(mesh).flipped == 1);
  CHECK(check_mesh(mesh).findings.empty());
  // Most of them turned: the whole is right in the end all the same.
  for (std::size_t t = 0; t < 9; ++t) turn(mesh.triangles[t]);
  CHECK(repair_mesh(mesh).flipped == 9);
  CHECK(check_mesh(mesh).findings.empty());
}

TEST_CASE("a mesh that is inside out is found and turned") {
  TriangleMesh mesh = cube();
  for (Triangle& t : mesh.triangles) turn(t);
  check_only(mesh, MeshFault::kInsideOut, 12, false);
  CHECK(repair_mesh(mesh).flipped == 12);
  CHECK(check_mesh(mesh).findings.empty());
}

TEST_CASE("repair leaves a cavity as it is") {
  TriangleMesh mesh = cube();
  TriangleMesh cavity = box({0.04, 0.04, 0.04}, {0.06, 0.06, 0.06});
  for (Triangle& t : cavity.triangles) turn(t);
  append(mesh, cavity);
  CHECK(repair_mesh(mesh).flipped == 0);
  CHECK(check_mesh(mesh).volume == doctest::Approx(1e-3 - 8e-6));
  CHECK(usable(check_mesh(mesh)));
}

TEST_CASE("a size that no hand plays with is a warning that names the unit") {
  for (const double side : {100.0, 1e-4}) {
    const TriangleMesh mesh = box({0.0, 0.0, 0.0}, {side, side, side});
    check_only(mesh, MeshFault::kUnits, 1, true);
    CHECK(describe(*only_finding(mesh)).find("--unit mm") != std::string::npos);
  }
}

TEST_CASE("separate pieces are noted") {
  TriangleMesh mesh = cube();
  append(mesh, box({0.2, 0.0, 0.0}, {0.3, 0.1, 0.1}));
  append(mesh, box({0.4, 0.0, 0.0}, {0.5, 0.1, 0.1}));
  check_only(mesh, MeshFault::kPieces, 3, true);
}

TEST_CASE("boxes pushed into each other cross, boxes side by side do not") {
  TriangleMesh mesh = cube();
  append(mesh, box({0.05, 0.02, 0.03}, {0.17, 0.09, 0.08}));
  const MeshReport report = check_mesh(mesh);
  REQUIRE(report.findings.size() == 2);
  CHECK(report.findings[1].fault == MeshFault::kCrossing);
  CHECK(report.findings[1].severity == FaultSeverity::kWarning);
  // The far box's four long sides, two triangles each, go through the two triangles of the cube's.
  CHECK(report.findings[1].count == 10);
}

TEST_CASE("triangles cross when a side of one meets the inside of the other, and only then") {
  SplitMix64 random(3);
  int crossing = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    TriangleMesh mesh;
    for (int k = 0; k < 6; ++k) {
      mesh.vertices.emplace_back(random.uniform(), random.uniform(), random.uniform());
    }
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    bool truth = false;
    for (const Triangle& t : mesh.triangles) {
      const Triangle& other = t[0] == 0 ? mesh.triangles[1] : mesh.triangles[0];
      for (std::size_t k = 0; k < 3; ++k) {
        truth = truth || meets(mesh, t[k], t[(k + 1) % 3], other);
      }
    }
    crossing += truth ? 1 : 0;
    REQUIRE(find_crossings(mesh).count == (truth ? 2 : 0));
  }
  CHECK(crossing > 100);
}

TEST_CASE("welding joins equal vertices, takes minus zero for zero, and drops unused ones") {
  TriangleMesh soup;
  SplitMix64 random(1);
  const TriangleMesh sound = cube();
  soup.vertices.emplace_back(9.0, 9.0, 9.0);
  for (const Triangle& t : sound.triangles) {
    const auto first = static_cast<std::int32_t>(soup.vertices.size());
    for (const std::int32_t i : t) {
      Vector3 p = sound.vertices[static_cast<std::size_t>(i)];
      for (int k = 0; k < 3; ++k) {
        if (p[k] == 0.0 && random.chance(0.5)) p[k] = -0.0;
      }
      soup.vertices.push_back(p);
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  const TriangleMesh welded = weld(soup);
  CHECK(welded.vertices.size() == 8);
  CHECK(welded.triangles.size() == 12);
  CHECK(check_mesh(welded).findings.empty());
  CHECK(check_mesh(welded).volume == doctest::Approx(1e-3));
}

TEST_CASE("welding takes coordinates that are no numbers") {
  TriangleMesh mesh = cube();
  for (Vector3& p : mesh.vertices) p.x() = std::numeric_limits<double>::quiet_NaN();
  CHECK(weld(mesh).triangles.size() == 12);
}

}  // namespace hapticd::test
