// See mesh_measures.h.
#include "tests/server/model/shapes/mesh_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace hapticd::test {
namespace {

using Long3 = std::array<long double, 3>;

Long3 long_of(const Vector3& p) { return {p.x(), p.y(), p.z()}; }

Long3 difference(const Long3& a, const Long3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Long3 cross(const Long3& a, const Long3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

long double dot(const Long3& a, const Long3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

bool indices_valid(const TriangleMesh& mesh) {
  const auto count = static_cast<std::int32_t>(mesh.vertices.size());
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](std::int32_t i) { return i >= 0 && i < count; });
  });
}

void count_edges(const TriangleMesh& mesh, MeshMeasures& measures) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
  std::vector<std::int32_t> above(mesh.vertices.size(), -1);
  std::set<std::int32_t> used;
  const auto root = [&](std::int32_t i) {
    while (above[static_cast<std::size_t>(i)] >= 0) i = above[static_cast<std::size_t>(i)];
    return i;
  };
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = t[k];
      const std::int32_t b = t[(k + 1) % 3];
      ++edges[{a, b}];
      used.insert(a);
      const std::int32_t root_a = root(a);
      const std::int32_t root_b = root(b);
      if (root_a != root_b) above[static_cast<std::size_t>(root_a)] = root_b;
    }
  }
  measures.closed = used.size() == mesh.vertices.size();
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    measures.closed = measures.closed && count == 1 && back != edges.end() && back->second == 1;
  }
  measures.pieces = std::count(above.begin(), above.end(), -1);
  measures.euler = static_cast<std::int64_t>(mesh.vertices.size() + mesh.triangles.size()) -
                   static_cast<std::int64_t>(edges.size() / 2);
}

}  // namespace

MeshMeasures measure(const TriangleMesh& mesh) {
  MeshMeasures measures;
  if (mesh.triangles.empty() || !indices_valid(mesh)) return measures;
  count_edges(mesh, measures);
  measures.flattest = 1.0L;
  for (const Triangle& t : mesh.triangles) {
    std::array<Long3, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = long_of(mesh.vertices[static_cast<std::size_t>(t[k])]);
    }
    const Long3 normal = cross(difference(p[1], p[0]), difference(p[2], p[0]));
    const long double twice_area = std::sqrt(dot(normal, normal));
    measures.area += 0.5L * twice_area;
    measures.volume += dot(p[0], cross(p[1], p[2])) / 6.0L;
    for (std::size_t k = 0; k < 3; ++k) {
      const Long3 side = difference(p[(k + 1) % 3], p[k]);
      measures.flattest = std::min(measures.flattest, twice_area / dot(side, side));
    }
  }
  measures.low = measures.high = mesh.vertices.front();
  for (const Vector3& p : mesh.vertices) {
    measures.low = measures.low.cwiseMin(p);
    measures.high = measures.high.cwiseMax(p);
  }
  return measures;
}

Vector3 point_of(const TriangleMesh& mesh, const Triangle& triangle, double u, double v) {
  const Vector3& a = mesh.vertices[static_cast<std::size_t>(triangle[0])];
  const Vector3& b = mesh.vertices[static_cast<std::size_t>(triangle[1])];
  const Vector3& c = mesh.vertices[static_cast<std::size_t>(triangle[2])];
  return a + u * (b - a) + v * (c - a);
}

}  // namespace hapticd::test
