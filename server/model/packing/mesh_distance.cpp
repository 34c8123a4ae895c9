// See mesh_distance.h.
#include "server/model/packing/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "core/geometry/closest_point.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Triangles in a leaf of the tree. Normal value 4; more tests triangles in vain, fewer makes a
/// deeper tree.
constexpr std::int32_t kLeafTriangles = 4;
/// Depth of the stack of a search: the tree is halved by count, so at most 31 levels.
constexpr int kStack = 64;
/// Largest coordinate accepted, m: fourth powers stay finite.
constexpr double kMaxCoordinate = 1e70;
/// Square of the sine of the angle below which a triangle counts as a segment. Normal value 1e-24
/// (heights below 1e-12 of the sides are lost in the rounding of coordinates anyway).
constexpr double kFlatSquared = 1e-24;

double squared_distance_to_box(const Vector3& low, const Vector3& high, const Vector3& p) noexcept {
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double out = std::max(std::max(low[k] - p[k], p[k] - high[k]), 0.0);
    sum += out * out;
  }
  return sum;
}

void check(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw std::invalid_argument("mesh distance: no triangles");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!(mesh.vertices[i].array().abs() <= kMaxCoordinate).all()) {
      throw std::invalid_argument("mesh distance: vertex " + std::to_string(i) + " is not finite");
    }
  }
  const auto count = static_cast<std::int64_t>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::int32_t v : mesh.triangles[i]) {
      if (v >= 0 && v < count) continue;
      throw std::invalid_argument("mesh distance: triangle " + std::to_string(i) +
                                  " has a vertex that does not exist");
    }
  }
}

/// Side of a triangle, to find the two triangles of every edge.
struct Side {
  std::int32_t low, high;  ///< vertices
  std::int32_t triangle;
  std::int32_t edge;  ///< 0, 1, 2: ab, bc, ca
};

}  // namespace

MeshDistance::MeshDistance(const TriangleMesh& mesh) {
  check(mesh);
  build_tree(mesh);
  build_normals(mesh);
}

void MeshDistance::build_tree(const TriangleMesh& mesh) {
  std::vector<Corner3> source;
  std::vector<std::int32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  for (const Triangle& t : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, t);
    source.push_back({a, b, c, static_cast<std::int32_t>(source.size())});
  }
  struct Range {
    std::int32_t node, first, count;
  };
  std::vector<Range> rest{{0, 0, static_cast<std::int32_t>(order.size())}};
  nodes_.resize(1);
  while (!rest.empty()) {
    const Range range = rest.back();
    rest.pop_back();
    const auto begin = order.begin() + range.first;
    const auto end = begin + range.count;
    Vector3 low = source[static_cast<std::size_t>(*begin)].a;
    Vector3 high = low;
    for (auto i = begin; i != end; ++i) {
      const Corner3& t = source[static_cast<std::size_t>(*i)];
      low = low.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
      high = high.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
    }
    Node& node = nodes_[static_cast<std::size_t>(range.node)];
    node = {low, high, range.first, range.count};
    if (range.count <= kLeafTriangles) continue;
    const Vector3 extent = high - low;
    int axis = extent.y() > extent.x() ? 1 : 0;
    if (extent.z() > extent[axis]) axis = 2;
    const std::int32_t left = range.count / 2;
    std::nth_element(begin, begin + left, end, [&](std::int32_t i, std::int32_t j) {
      const Corner3& s = source[static_cast<std::size_t>(i)];
      const Corner3& t = source[static_cast<std::size_t>(j)];
      const double ps = s.a[axis] + s.b[axis] + s.c[axis];
      const double pt = t.a[axis] + t.b[axis] + t.c[axis];
      return ps != pt ? ps < pt : i < j;
    });
    const auto child = static_cast<std::int32_t>(nodes_.size());
    node.first = child;
    node.count = 0;
    nodes_.resize(nodes_.size() + 2);
    rest.push_back({child + 1, range.first + left, range.count - left});
    rest.push_back({child, range.first, left});
  }
  for (const std::int32_t i : order) triangles_.push_back(source[static_cast<std::size_t>(i)]);
}

void MeshDistance::build_normals(const TriangleMesh& mesh) {
  std::vector<Vector3> of_vertex(mesh.vertices.size(), Vector3(0.0, 0.0, 0.0));
  std::vector<Side> sides;
  normals_.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const std::array<Vector3, 3> p = corners(mesh, t);
    const Vector3 normal = unit_or_zero((p[1] - p[0]).cross(p[2] - p[0]));
    normals_[i][0] = normal;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const Vector3 to_next = p[next] - p[k];
      const Vector3 to_last = p[(k + 2) % 3] - p[k];
      const double angle = arctangent2(length(to_next.cross(to_last)), dot(to_next, to_last));
      of_vertex[static_cast<std::size_t>(t[k])] += angle * normal;
      sides.push_back({std::min(t[k], t[next]), std::max(t[k], t[next]),
                       static_cast<std::int32_t>(i), static_cast<std::int32_t>(k)});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
    return std::array{s.low, s.high, s.triangle, s.edge} <
           std::array{t.low, t.high, t.triangle, t.edge};
  });
  for (std::size_t first = 0; first < sides.size();) {
    Vector3 sum(0.0, 0.0, 0.0);
    std::size_t end = first;
    for (; end < sides.size() && sides[end].low == sides[first].low &&
           sides[end].high == sides[first].high;
         ++end) {
      sum += normals_[static_cast<std::size_t>(sides[end].triangle)][0];
    }
    for (; first < end; ++first) {
      const Side& side = sides[first];
      normals_[static_cast<std::size_t>(side.triangle)][1 + static_cast<std::size_t>(side.edge)] =
          sum;
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      normals_[i][4 + k] = of_vertex[static_cast<std::size_t>(mesh.triangles[i][k])];
    }
  }
}

MeshDistance::Hit MeshDistance::nearest_on(const Corner3& t, const Vector3& p) noexcept {
  // The corner's or side's region that p is in front of, else the face (C. Ericson, Real-Time
  // Collision Detection, 2005, 5.1.5).
  const Vector3 ab = t.b - t.a;
  const Vector3 ac = t.c - t.a;
  const Vector3 ap = p - t.a;
  const Vector3 bp = p - t.b;
  const Vector3 cp = p - t.c;
  const double d1 = dot(ab, ap);
  const double d2 = dot(ac, ap);
  const double d3 = dot(ab, bp);
  const double d4 = dot(ac, bp);
  const double d5 = dot(ab, cp);
  const double d6 = dot(ac, cp);
  const auto hit = [&](const Vector3& on, Feature feature) {
    const Vector3 offset = p - on;
    return Hit{dot(offset, offset), on, t.id, feature};
  };
  if (d1 <= 0.0 && d2 <= 0.0) return hit(t.a, Feature::kVertex0);
  if (d3 >= 0.0 && d4 <= d3) return hit(t.b, Feature::kVertex1);
  if (d6 >= 0.0 && d5 <= d6) return hit(t.c, Feature::kVertex2);
  const double vc = d1 * d4 - d3 * d2;
  const double vb = d5 * d2 - d1 * d6;
  const double va = d3 * d6 - d5 * d4;
  const double area = (va + vb) + vc;
  if (!(va > 0.0 && vb > 0.0 && vc > 0.0 && area > kFlatSquared * (dot(ab, ab) * dot(ac, ac)))) {
    return nearest_on_sides(t, p);
  }
  return hit(t.a + ((vb / area) * ab + (vc / area) * ac), Feature::kFace);
}

MeshDistance::Hit MeshDistance::nearest_on_sides(const Corner3& t, const Vector3& p) noexcept {
  Hit best;
  best.id = t.id;
  const std::array<const Vector3*, 4> corner{&t.a, &t.b, &t.c, &t.a};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 side = *corner[k + 1] - *corner[k];
    const Vector3 to = p - *corner[k];
    const double whole = dot(side, side);
    const double along = dot(side, to);
    Vector3 on = *corner[k];
    Feature feature = static_cast<Feature>(4 + k);
    if (along >= whole && along > 0.0) {
      on = *corner[k + 1];
      feature = static_cast<Feature>(4 + (k + 1) % 3);
    } else if (along > 0.0) {
      on += (along / whole) * side;
      feature = static_cast<Feature>(1 + k);
    }
    const Vector3 offset = p - on;
    const double squared = dot(offset, offset);
    if (squared < best.squared) best = {squared, on, t.id, feature};
  }
  return best;
}

MeshDistance::Hit MeshDistance::search(const Vector3& p) const noexcept {
  struct Entry {
    double squared;
    std::int32_t node;
  };
  std::array<Entry, kStack> stack;
  std::size_t size = 0;
  Hit best;
  stack[size++] = {squared_distance_to_box(nodes_[0].low, nodes_[0].high, p), 0};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.squared > best.squared) continue;
    const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
    if (node.count == 0) {
      const auto child = [&](std::int32_t i) {
        const Node& c = nodes_[static_cast<std::size_t>(i)];
        return Entry{squared_distance_to_box(c.low, c.high, p), i};
      };
      Entry near = child(node.first);
      Entry far = child(node.first + 1);
      if (far.squared < near.squared) std::swap(near, far);
      if (far.squared <= best.squared) stack[size++] = far;
      if (near.squared <= best.squared) stack[size++] = near;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const Hit hit = nearest_on(triangles_[static_cast<std::size_t>(i)], p);
      if (hit.squared < best.squared || (hit.squared == best.squared && hit.id < best.id)) {
        best = hit;
      }
    }
  }
  return best;
}

bool MeshDistance::find_nearer(const Vector3& p, double r, NearestPoint& found) const noexcept {
  if (!(r > 0.0)) return false;
  const double limit = r * r;
  std::array<std::int32_t, kStack> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[--size])];
    if (node.count == 0) {
      const auto to_child = [&](std::int32_t i) {
        const Node& c = nodes_[static_cast<std::size_t>(i)];
        return squared_distance_to_box(c.low, c.high, p);
      };
      const double left = to_child(node.first);
      const double right = to_child(node.first + 1);
      const std::int32_t near = left <= right ? node.first : node.first + 1;
      if (std::max(left, right) < limit) stack[size++] = 2 * node.first + 1 - near;
      if (std::min(left, right) < limit) stack[size++] = near;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const Hit hit = nearest_on(triangles_[static_cast<std::size_t>(i)], p);
      if (!(hit.squared < limit)) continue;
      found = {std::sqrt(hit.squared), hit.p, hit.id};
      return true;
    }
  }
  return false;
}

NearestPoint MeshDistance::nearest(const Vector3& p) const noexcept {
  const Hit hit = search(p);
  return {std::sqrt(hit.squared), hit.p, hit.id};
}

NearestPoint MeshDistance::nearest_by_exhaustion(const Vector3& p) const noexcept {
  Hit best;
  for (const Corner3& triangle : triangles_) {
    const Hit hit = nearest_on(triangle, p);
    const bool nearer = hit.squared < best.squared;
    if (nearer || (hit.squared == best.squared && hit.id < best.id)) best = hit;
  }
  return {std::sqrt(best.squared), best.p, best.id};
}

double MeshDistance::signed_distance(const Vector3& p) const noexcept {
  NearestPoint nearest;
  return signed_distance(p, nearest);
}

double MeshDistance::signed_distance(const Vector3& p, NearestPoint& nearest) const noexcept {
  const Hit hit = search(p);
  nearest = {std::sqrt(hit.squared), hit.p, hit.id};
  const Vector3& normal =
      normals_[static_cast<std::size_t>(hit.id)][static_cast<std::size_t>(hit.feature)];
  return dot(normal, p - hit.p) < 0.0 ? -nearest.distance : nearest.distance;
}

}  // namespace hapticd
