// See mesh_crossings.h.
#include "server/model/packing/mesh_crossings.h"

#include <algorithm>
#include <numeric>

namespace hapticd {
namespace {

using Corners = std::array<Vector3, 3>;

struct Swept {
  Corners corners;
  Vector3 low, high;
  std::int32_t id;
};

/// Six times the volume of the tetrahedron.
double volume(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool same_sign(double a, double b) { return (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0); }

/// Whether the inside of segment pq goes through the inside of the triangle.
bool goes_through(const Vector3& p, const Vector3& q, const Corners& t) {
  const double side_p = volume(t[0], t[1], t[2], p);
  const double side_q = volume(t[0], t[1], t[2], q);
  if (!same_sign(side_p, -side_q)) return false;
  const double a = volume(p, q, t[0], t[1]);
  const double b = volume(p, q, t[1], t[2]);
  const double c = volume(p, q, t[2], t[0]);
  return same_sign(a, b) && same_sign(b, c);
}

bool cross(const Corners& a, const Corners& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (goes_through(a[k], a[(k + 1) % 3], b) || goes_through(b[k], b[(k + 1) % 3], a)) return true;
  }
  return false;
}

bool share_vertex(const Triangle& a, const Triangle& b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

bool boxes_meet(const Swept& a, const Swept& b) {
  return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
}

std::vector<Swept> swept_triangles(const TriangleMesh& mesh) {
  std::vector<Swept> swept;
  swept.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, t);
    swept.push_back({{a, b, c},
                     a.cwiseMin(b).cwiseMin(c),
                     a.cwiseMax(b).cwiseMax(c),
                     static_cast<std::int32_t>(swept.size())});
  }
  return swept;
}

}  // namespace

MeshCrossings find_crossings(const TriangleMesh& mesh) {
  MeshCrossings crossings;
  if (mesh.triangles.empty()) return crossings;
  std::vector<Swept> swept = swept_triangles(mesh);
  Vector3 low = swept[0].low;
  Vector3 high = swept[0].high;
  for (const Swept& entry : swept) {
    low = low.cwiseMin(entry.low);
    high = high.cwiseMax(entry.high);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  std::sort(swept.begin(), swept.end(), [axis](const Swept& a, const Swept& b) {
    return a.low[axis] != b.low[axis] ? a.low[axis] < b.low[axis] : a.id < b.id;
  });

  std::vector<bool> crossed(swept.size());
  for (std::size_t i = 0; i < swept.size(); ++i) {
    for (std::size_t j = i + 1; j < swept.size() && swept[j].low[axis] <= swept[i].high[axis];
         ++j) {
      const Swept& a = swept[i];
      const Swept& b = swept[j];
      const auto t = static_cast<std::size_t>(a.id);
      const auto u = static_cast<std::size_t>(b.id);
      if (!boxes_meet(a, b) || share_vertex(mesh.triangles[t], mesh.triangles[u])) continue;
      if (cross(a.corners, b.corners)) crossed[t] = crossed[u] = true;
    }
  }
  crossings.count = std::count(crossed.begin(), crossed.end(), true);
  if (crossings.count > 0) {
    const auto first = std::find(crossed.begin(), crossed.end(), true) - crossed.begin();
    crossings.triangle = static_cast<std::int32_t>(first);
    const auto [a, b, c] = corners(mesh, mesh.triangles[static_cast<std::size_t>(first)]);
    crossings.p = (a + b + c) / 3.0;
  }
  return crossings;
}

}  // namespace hapticd
