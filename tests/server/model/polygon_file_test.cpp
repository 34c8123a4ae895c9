// Polygons of mesh files: prisms over random outlines, convex, hollow, combs, rings joined by a
// bridge, in random planes and scales, are read as the solid they are; what no triangles can stand
// for is refused with its face. Truth: the shoelace formula and a count of crossings in long
// double (outlines.h), in the plane the outline was drawn in.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/model/mesh_file.h"
#include "server/model/packing/mesh_check.h"
#include "tests/server/model/outlines.h"
#include "tests/server/model/temporary_folder.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// A plane of the world: p = o + s (x u + y v + z w), the bases orthonormal.
struct Placing {
  Vector3 o, u, v, w;
  double s;

  [[nodiscard]] Vector3 place(const Point& p, double z) const {
    return o + s * (static_cast<double>(p[0]) * u + static_cast<double>(p[1]) * v + z * w);
  }
  [[nodiscard]] std::array<Real, 3> back(const Vector3& p) const {
    const Vector3 d = (p - o) / s;
    return {Real{d.dot(u)}, Real{d.dot(v)}, Real{d.dot(w)}};
  }
};

Vector3 direction(SplitMix64& random) {
  const auto d = random.direction();
  return {d[0], d[1], d[2]};
}

Placing random_placing(SplitMix64& random) {
  Placing placing;
  placing.w = direction(random);
  if (random.chance(0.3)) placing.w = Vector3::Unit(static_cast<Eigen::Index>(random.below(3)));
  placing.u = placing.w.cross(direction(random)).normalized();
  placing.v = placing.w.cross(placing.u);
  placing.s = std::pow(10.0, random.uniform(-3.0, 3.0));
  placing.o = placing.s * random.uniform(0.0, 20.0) * direction(random);
  return placing;
}

std::string line_of(const Vector3& p) {
  std::array<char, 96> line{};
  std::snprintf(line.data(), line.size(), "%.9g %.9g %.9g\n", p.x(), p.y(), p.z());
  return line.data();
}

/// The prism over `outline`, 1 high: two caps and a wall of quadrilaterals; as OBJ, or as PLY.
std::string prism(const Outline& outline, const Placing& placing, std::size_t first, bool ply) {
  const std::size_t n = outline.size();
  std::string text;
  std::string faces;
  for (const double z : {0.0, 1.0}) {
    for (const Point& p : outline) text += (ply ? "" : "v ") + line_of(placing.place(p, z));
  }
  const auto add = [&](const std::vector<std::size_t>& face) {
    faces += ply ? std::to_string(face.size()) : "f";
    for (const std::size_t i : face) faces += " " + std::to_string(ply ? i : i + 1);
    faces += "\n";
  };
  std::vector<std::size_t> low;
  std::vector<std::size_t> high;
  std::size_t walls = 0;
  for (std::size_t k = 0; k < n; ++k) {
    low.push_back((first + n - k) % n);
    high.push_back(n + (first + k) % n);
  }
  add(low);
  add(high);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    // No wall stands on a bridge, which is there and back.
    bool bridge = false;
    for (std::size_t k = 0; k < n; ++k) {
      bridge = bridge || (outline[k] == outline[j] && outline[(k + 1) % n] == outline[i]);
    }
    if (bridge) continue;
    add({i, j, n + j, n + i});
    ++walls;
  }
  if (!ply) return text + faces;
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(2 * n) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(walls + 2) + "\nproperty list uchar int vertex_indices\nend_header\n" +
         text + faces;
}

/// How many triangles of the upper cap have `q` in them.
int covers(const std::vector<Outline>& cap, const Point& q) {
  return static_cast<int>(
      std::count_if(cap.begin(), cap.end(), [&](const Outline& t) { return contains(t, q); }));
}

void check_prism(SplitMix64& random, const Outline& outline, const std::string& path,
                 const Placing& placing) {
  const TriangleMesh mesh = read_mesh(path, 1.0).mesh;
  const Real area = shoelace(outline);
  const MeshReport report = check_mesh(mesh);
  for (const MeshFinding& finding : report.findings) CAPTURE(describe(finding));
  REQUIRE(usable(report));
  const double volume = static_cast<double>(area) * std::pow(placing.s, 3);
  REQUIRE(report.volume == within(volume, 1e-3));

  std::vector<Outline> cap;
  Real cap_area = 0;
  for (const Triangle& t : mesh.triangles) {
    Outline flat;
    bool high = true;
    for (const Vector3& p : corners(mesh, t)) {
      const auto back = placing.back(p);
      high = high && back[2] > Real{0.5L};
      flat.push_back({back[0], back[1]});
    }
    if (!high) continue;
    cap.push_back(flat);
    cap_area += std::abs(shoelace(flat));
  }
  REQUIRE(cap_area == within(static_cast<double>(area), 1e-3));
  Point low = outline[0];
  Point top = outline[0];
  for (const Point& p : outline) {
    for (std::size_t k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], p[k]);
      top[k] = std::max(top[k], p[k]);
    }
  }
  for (int k = 0; k < 40; ++k) {
    const Point q{low[0] + (top[0] - low[0]) * random.uniform(-0.1, 1.1),
                  low[1] + (top[1] - low[1]) * random.uniform(-0.1, 1.1)};
    const auto near_edge = [&](const Outline& t) { return distance(t, q) < Real{1e-3L}; };
    if (distance(outline, q) < Real{1e-3L} || std::any_of(cap.begin(), cap.end(), near_edge))
      continue;
    REQUIRE(covers(cap, q) == (contains(outline, q) ? 1 : 0));
  }
}

/// What reading says; "" when it reads.
std::string complaint(const std::string& path) {
  try {
    static_cast<void>(read_mesh(path, 1.0));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

const Placing kHere{Vector3::Zero(), Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ(), 1.0};

}  // namespace

TEST_CASE("a prism over any outline is read as the solid it is, whatever its plane and scale") {
  const TemporaryFolder folder;
  SplitMix64 random(27);
  for (std::int64_t trial = 0; trial < scaled(1500); ++trial) {
    const auto many = static_cast<std::size_t>(4 + random.below(random.chance(0.1) ? 60 : 12));
    Outline outline;
    bool bridged = false;
    switch (random.below(6)) {
      case 0:
        outline = ellipse(random, many);
        break;
      case 1:
        outline = around(random, many, 0.15);
        break;
      case 2:
        outline = comb(random, 2 + random.below(6));
        break;
      case 3:
        outline = stairs(random, 2 + random.below(5));
        break;
      case 4:
        outline = spiral(2 + static_cast<int>(random.below(6)));
        break;
      default:
        outline = ring(random);
        bridged = true;
        break;
    }
    // A bridge is an edge there and back: no corner stands on one way of it.
    if (!bridged && random.chance(0.3)) outline = with_corners_on_edges(random, outline);
    const Placing placing = random_placing(random);
    const bool ply = random.chance(0.3);
    const std::string path = folder.write(
        ply ? "p.ply" : "p.obj", prism(outline, placing, random.below(outline.size()), ply));
    CAPTURE(trial);
    CAPTURE(outline.size());
    CAPTURE(placing.s);
    check_prism(random, outline, path, placing);
  }
}

TEST_CASE("a disc, an arrowhead and an L are read from any corner on, a corner written twice too") {
  const TemporaryFolder folder;
  SplitMix64 random(28);
  Outline disc;
  for (int k = 0; k < 64; ++k) {
    const Real angle = 2 * std::numbers::pi_v<Real> * k / 64;
    disc.push_back({std::cos(angle), std::sin(angle)});
  }
  const Outline arrowhead{{0, 0}, {2, 1}, {0, 2}, {Real{0.5L}, 1}};
  const Outline bracket{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (const Outline& outline : {disc, arrowhead, bracket}) {
    for (std::size_t first = 0; first < outline.size(); ++first) {
      check_prism(random, outline, folder.write("p.obj", prism(outline, kHere, first, false)),
                  kHere);
    }
  }
  const std::string twice =
      folder.write("twice.obj",
                   "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                   "f 1 4 3 3 2 1\nf 5 6 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7 7\nf 4 1 5 8\n");
  const MeshReport report = check_mesh(read_mesh(twice, 1.0).mesh);
  CHECK(usable(report));
  CHECK(report.volume == doctest::Approx(1.0));
}

TEST_CASE("a polygon that crosses itself is refused, with its face, its place and a remedy") {
  const TemporaryFolder folder;
  SplitMix64 random(29);
  const Outline bow_tie{{0, 0}, {1, 1}, {1, 0}, {0, 1}};
  const Outline uneven_bow_tie{{0, 0}, {3, 1}, {3, 0}, {0, 2}};
  Outline star;
  for (int k = 0; k < 5; ++k) {
    const Real angle = 4 * std::numbers::pi_v<Real> * k / 5;
    star.push_back({std::cos(angle), std::sin(angle)});
  }
  const Outline swapped{{0, 0}, {2, 0}, {2, 2}, {1, 3}, {0, 2}, {3, 1}};
  for (std::int64_t trial = 0; trial < scaled(300); ++trial) {
    const std::array<const Outline*, 4> outlines{&bow_tie, &uneven_bow_tie, &star, &swapped};
    const Outline& outline = *outlines[random.below(outlines.size())];
    const Placing placing = random_placing(random);
    const bool ply = random.chance(0.3);
    const std::string path = folder.write(
        ply ? "x.ply" : "x.obj", prism(outline, placing, random.below(outline.size()), ply));
    const std::string said = complaint(path);
    CAPTURE(said);
    REQUIRE(said.starts_with(path + ": face 1"));
    REQUIRE(said.find("crosses itself") != std::string::npos);
    REQUIRE(said.find("Triangulate") != std::string::npos);
  }
}

TEST_CASE(
    "a polygon whose corners are not in a plane is refused beyond the bound and read below it") {
  const TemporaryFolder folder;
  // A square folded along a diagonal by the angle f: its triangles have 1 / cos(f / 2) of the area.
  const auto folded = [&](double degrees) {
    const double half = 0.5 * degrees * std::numbers::pi / 180.0;
    std::string text;
    for (const double side : {-1.0, 1.0}) {
      text += "v 0 " + std::to_string(side) + " 0\n";
      text += "v " + std::to_string(side * std::cos(half)) + " 0 " +
              std::to_string(std::sin(half)) + "\n";
    }
    return complaint(folder.write("folded.obj", text + "f 1 4 3 2\n"));
  };
  for (const double degrees : {0.0, 5.0, 15.0, 22.0}) CHECK(folded(degrees).empty());
  for (const double degrees : {23.5, 45.0, 90.0, 150.0}) {
    const std::string said = folded(degrees);
    CAPTURE(said);
    CHECK(said.find("face 1") != std::string::npos);
    CHECK(said.find("not flat") != std::string::npos);
  }
}

TEST_CASE("the face that is refused is the one at fault") {
  const TemporaryFolder folder;
  std::string text = prism({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, kHere, 0, false);
  text += "v 0 0 2\nv 1 1 2\nv 1 0 2\nv 0 1 2\nf 9 10 11 12\n";
  const std::string said = complaint(folder.write("late.obj", text));
  CAPTURE(said);
  CHECK(said.find("face 7") != std::string::npos);
  CHECK(said.find("of 4 corners that begins at 0 0 2") != std::string::npos);
}

TEST_CASE("a polygon of thousands of corners is cut or refused, and never takes long") {
  const TemporaryFolder folder;
  SplitMix64 random(30);
  const Outline large = around(random, 2000, 0.5);
  check_prism(random, large, folder.write("p.obj", prism(large, kHere, 0, false)), kHere);
  const Outline larger = around(random, 5000, 0.5);
  CHECK(complaint(folder.write("q.obj", prism(larger, kHere, 0, false))).find("4096") !=
        std::string::npos);
}

}  // namespace hapticd::test
