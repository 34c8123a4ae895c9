// See test_meshes.h.
#include "tests/server/model/packing/test_meshes.h"

#include <cmath>
#include <map>

namespace hapticd::test {
namespace {

using Long3 = std::array<long double, 3>;

Long3 minus(const Long3& a, const Long3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
long double dot(const Long3& a, const Long3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Long3 cross(const Long3& a, const Long3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Long3 widen(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

long double to_segment(const Long3& a, const Long3& b, const Long3& p) {
  const Long3 ab = minus(b, a);
  const Long3 ap = minus(p, a);
  long double t = dot(ab, ab) > 0 ? dot(ap, ab) / dot(ab, ab) : 0;
  t = t < 0 ? 0 : (t > 1 ? 1 : t);
  const Long3 d{ap[0] - t * ab[0], ap[1] - t * ab[1], ap[2] - t * ab[2]};
  return std::sqrt(dot(d, d));
}

/// In front of the inside of the triangle the distance to its plane, else that to the nearest side.
long double to_triangle(const Long3& a, const Long3& b, const Long3& c, const Long3& p) {
  const Long3 n = cross(minus(b, a), minus(c, a));
  const bool inside = dot(cross(n, minus(b, a)), minus(p, a)) > 0 &&
                      dot(cross(n, minus(c, b)), minus(p, b)) > 0 &&
                      dot(cross(n, minus(a, c)), minus(p, c)) > 0;
  if (inside) return std::fabs(dot(n, minus(p, a))) / std::sqrt(dot(n, n));
  return std::fmin(to_segment(a, b, p), std::fmin(to_segment(b, c, p), to_segment(c, a, p)));
}

}  // namespace

TriangleMesh box_mesh(const Vector3& half) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1) != 0 ? half.x() : -half.x(),
                               (i & 2) != 0 ? half.y() : -half.y(),
                               (i & 4) != 0 ? half.z() : -half.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TriangleMesh cube_sphere(int n, const std::function<Vector3(const Vector3&)>& place) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::int32_t> ids;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [it, fresh] = ids.try_emplace(at, static_cast<std::int32_t>(ids.size()));
    if (fresh) {
      const Vector3 p(at[0], at[1], at[2]);
      mesh.vertices.push_back(place(p / std::sqrt(p.squaredNorm())));
    }
    return it->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int side : {-n, n}) {
      for (int i = -n; i < n; i += 2) {
        for (int j = -n; j < n; j += 2) {
          const auto corner = [&](int di, int dj) {
            std::array<int, 3> at{};
            at[axis] = side;
            at[(axis + 1) % 3] = i + 2 * di;
            at[(axis + 2) % 3] = j + 2 * dj;
            return vertex(at);
          };
          const std::int32_t a = corner(0, 0);
          const std::int32_t b = side > 0 ? corner(1, 0) : corner(0, 1);
          const std::int32_t c = corner(1, 1);
          const std::int32_t d = side > 0 ? corner(0, 1) : corner(1, 0);
          mesh.triangles.push_back({a, b, c});
          mesh.triangles.push_back({a, c, d});
        }
      }
    }
  }
  return mesh;
}

TriangleMesh ellipsoid_mesh(int n, const Vector3& half) {
  return cube_sphere(n, [&](const Vector3& u) { return Vector3(u.cwiseProduct(half)); });
}

TriangleMesh blob_mesh(int n) {
  return cube_sphere(n, [](const Vector3& u) {
    const double x = u.x();
    const double y = u.y();
    const double z = u.z();
    const double bumps = x * x * x - 0.6 * y * y + 2.0 * x * y * z - 0.8 * z * z * z * x;
    return Vector3((1.0 + 0.35 * bumps) * u);
  });
}

long double exhaustive_distance(const TriangleMesh& mesh, const Vector3& p) {
  long double best = HUGE_VALL;
  for (const Triangle& t : mesh.triangles) {
    const auto corner = [&](std::size_t k) {
      return widen(mesh.vertices[static_cast<std::size_t>(t[k])]);
    };
    best = std::fmin(best, to_triangle(corner(0), corner(1), corner(2), widen(p)));
  }
  return best;
}

long double winding_number(const TriangleMesh& mesh, const Vector3& p) {
  long double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    std::array<Long3, 3> r{};
    std::array<long double, 3> size{};
    for (std::size_t k = 0; k < 3; ++k) {
      r[k] = minus(widen(mesh.vertices[static_cast<std::size_t>(t[k])]), widen(p));
      size[k] = std::sqrt(dot(r[k], r[k]));
    }
    // Van Oosterom and Strackee, "The solid angle of a plane triangle", 1983.
    const long double volume = dot(r[0], cross(r[1], r[2]));
    const long double rest = size[0] * size[1] * size[2] + dot(r[0], r[1]) * size[2] +
                             dot(r[1], r[2]) * size[0] + dot(r[2], r[0]) * size[1];
    sum += 2 * std::atan2(volume, rest);
  }
  return sum / (4 * 3.14159265358979323846L);
}

}  // namespace hapticd::test
