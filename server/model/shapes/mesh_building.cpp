// See mesh_building.h.
#include "server/model/shapes/mesh_building.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/math/elementary.h"
#include "server/model/packing/mesh_check.h"

namespace hapticd {
namespace {

std::int32_t index_of(std::size_t i) { return static_cast<std::int32_t>(i); }

/// Equal points become one vertex, and triangles that lose a corner by this go.
TriangleMesh joined(const TriangleMesh& mesh) {
  TriangleMesh result = weld(mesh);
  std::erase_if(result.triangles,
                [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  return result;
}

/// Corners of the icosahedron of circumradius 1, and its faces, counter-clockwise from outside.
struct Icosahedron {
  std::array<Vector3, 12> corners;
  std::array<Triangle, 20> faces;
};

Icosahedron icosahedron() {
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  const double size = 1.0 / std::sqrt(1.0 + golden * golden);
  const double a = size;
  const double b = size * golden;
  return {{Vector3{-a, b, 0}, Vector3{a, b, 0}, Vector3{-a, -b, 0}, Vector3{a, -b, 0},
           Vector3{0, -a, b}, Vector3{0, a, b}, Vector3{0, -a, -b}, Vector3{0, a, -b},
           Vector3{b, 0, -a}, Vector3{b, 0, a}, Vector3{-b, 0, -a}, Vector3{-b, 0, a}},
          {Triangle{0, 11, 5},  Triangle{0, 5, 1},  Triangle{0, 1, 7},  Triangle{0, 7, 10},
           Triangle{0, 10, 11}, Triangle{1, 5, 9},  Triangle{5, 11, 4}, Triangle{11, 10, 2},
           Triangle{10, 7, 6},  Triangle{7, 1, 8},  Triangle{3, 9, 4},  Triangle{3, 4, 2},
           Triangle{3, 2, 6},   Triangle{3, 6, 8},  Triangle{3, 8, 9},  Triangle{4, 9, 5},
           Triangle{2, 4, 11},  Triangle{6, 2, 10}, Triangle{8, 6, 7},  Triangle{9, 8, 1}}};
}

/// Triangles of a ladder between points k and n - 1 - k of the loop that starts at vertex `base`;
/// `flip` for the end that looks back.
void add_ladder(TriangleMesh& mesh, std::int32_t base, std::int32_t n, bool flip) {
  const auto add = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
    if (flip) std::swap(b, c);
    mesh.triangles.push_back({base + a, base + b, base + c});
  };
  for (std::int32_t k = 0; k + 1 < n - 1 - k; ++k) {
    add(k, k + 1, n - 1 - k);
    if (k + 1 != n - 2 - k) add(k + 1, n - 2 - k, n - 1 - k);
  }
}

}  // namespace

TriangleMesh loft(std::span<const Loop> loops) {
  const std::size_t n = loops.empty() ? 0 : loops.front().size();
  if (loops.size() < 2 || n < 3) throw std::invalid_argument("loft: too few loops or points");
  TriangleMesh mesh;
  for (const Loop& loop : loops) {
    if (loop.size() != n) throw std::invalid_argument("loft: loops of different size");
    mesh.vertices.insert(mesh.vertices.end(), loop.begin(), loop.end());
  }
  add_ladder(mesh, 0, index_of(n), true);
  for (std::size_t i = 0; i + 1 < loops.size(); ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::int32_t a = index_of(i * n + k);
      const std::int32_t b = index_of(i * n + (k + 1) % n);
      const std::int32_t c = b + index_of(n);
      const std::int32_t d = a + index_of(n);
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  add_ladder(mesh, index_of((loops.size() - 1) * n), index_of(n), false);
  return joined(mesh);
}

TriangleMesh revolve(std::span<const CurvePoint> profile, int segments) {
  std::vector<Loop> loops;
  for (const CurvePoint& point : profile) {
    Loop loop;
    for (int k = 0; k < segments; ++k) {
      // From the z axis to the x axis: counter-clockwise seen from +y.
      const SinCos turn = sin_cos(2.0 * kPi * k / segments);
      loop.emplace_back(point.u * turn.sin, point.v, point.u * turn.cos);
    }
    loops.push_back(std::move(loop));
  }
  return loft(loops);
}

TriangleMesh extrude(std::span<const CurvePoint> profile, double length, double edge, int segments,
                     int pieces) {
  // How far each loop lies inside the profile (-u) and where (v).
  std::vector<CurvePoint> ends;
  const double half_length = 0.5 * length - edge;
  add_quarter(ends, {-edge, -half_length, edge, 3}, segments);
  for (int k = 1; k < pieces; ++k) {
    ends.push_back({0.0, half_length * (2.0 * k / pieces - 1.0), 1.0, 0.0});
  }
  add_quarter(ends, {-edge, half_length, edge, 0}, segments);
  std::vector<Loop> loops;
  for (const CurvePoint& end : ends) {
    Loop loop;
    for (const CurvePoint& point : profile) {
      loop.emplace_back(point.u + end.u * point.normal_u, point.v + end.u * point.normal_v, end.v);
    }
    loops.push_back(std::move(loop));
  }
  return loft(loops);
}

TriangleMesh geodesic_sphere(int frequency) {
  if (frequency < 1) throw std::invalid_argument("geodesic_sphere: frequency below 1");
  const Icosahedron base = icosahedron();
  TriangleMesh mesh;
  for (const Triangle& face : base.faces) {
    const auto corner = [&](std::size_t k) -> const Vector3& {
      return base.corners[static_cast<std::size_t>(face[k])];
    };
    // On an edge one weight is zero and the sum of the other two commutes, so both faces of the
    // edge get the same bits.
    const auto vertex = [&](int i, int j) {
      const Vector3 p = corner(0) * (frequency - i - j) + corner(1) * i + corner(2) * j;
      mesh.vertices.emplace_back(p / std::sqrt(p.x() * p.x() + p.y() * p.y() + p.z() * p.z()));
      return index_of(mesh.vertices.size() - 1);
    };
    for (int i = 0; i < frequency; ++i) {
      for (int j = 0; i + j < frequency; ++j) {
        const std::int32_t a = vertex(i, j);
        const std::int32_t b = vertex(i + 1, j);
        const std::int32_t c = vertex(i, j + 1);
        mesh.triangles.push_back({a, b, c});
        if (i + j + 1 < frequency) mesh.triangles.push_back({b, vertex(i + 1, j + 1), c});
      }
    }
  }
  return joined(mesh);
}

void append(TriangleMesh& mesh, const TriangleMesh& part) {
  const std::int32_t base = index_of(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const Triangle& t : part.triangles) {
    mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
}

void move(TriangleMesh& mesh, const Matrix3& R, const Vector3& p_offset) {
  for (Vector3& p : mesh.vertices) {
    const Vector3 q = p;
    for (int i = 0; i < 3; ++i) {
      p[i] = R(i, 0) * q.x() + R(i, 1) * q.y() + R(i, 2) * q.z() + p_offset[i];
    }
  }
}

TriangleMesh mirrored(const TriangleMesh& mesh) {
  TriangleMesh result = mesh;
  for (Vector3& p : result.vertices) p.x() = -p.x();
  for (Triangle& t : result.triangles) std::swap(t[1], t[2]);
  return result;
}

void add_quarter(std::vector<CurvePoint>& curve, const QuarterCircle& arc, int segments) {
  for (int k = 0; k <= segments; ++k) {
    SinCos turn = sin_cos(0.5 * kPi * k / segments);
    if (k == segments) turn = {1.0, 0.0};
    double nu = turn.cos;
    double nv = turn.sin;
    for (int q = 0; q < arc.quarter % 4; ++q) {
      const double old = nu;
      nu = -nv;
      nv = old;
    }
    curve.push_back({arc.u + arc.radius * nu, arc.v + arc.radius * nv, nu, nv});
  }
}

}  // namespace hapticd
