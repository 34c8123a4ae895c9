// See implicit_mesh.h.
#include "server/model/shapes/implicit_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace hapticd {
namespace {

/// A lattice point moves onto the surface when that crosses one of its edges within this share of
/// the edge, for the long edges (along the axes) and the short ones (to the cubes' centres). The
/// values of Labelle and Shewchuk, with which no tetrahedron degenerates; smaller leaves slivers.
constexpr double kSnapLong = 0.24999;
constexpr double kSnapShort = 0.41189;
/// Most cubes of a lattice: about 1 GB.
constexpr double kMaxCells = 1 << 24;
/// Newton steps to the level, and the step of its difference quotients as a share of the cell.
/// Five steps leave nothing but rounding where the function is smooth.
constexpr int kNewtonSteps = 5;
constexpr double kDifference = 1e-4;
/// Share of the way to the mean of its neighbours that a vertex goes in one round.
constexpr double kEvening = 0.5;

using Edge = std::pair<std::int32_t, std::int32_t>;

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Corners of the cubes, then their centres.
struct Lattice {
  std::array<std::int32_t, 3> cubes{};
  std::int32_t corners = 0;
  Vector3 low{0.0, 0.0, 0.0};
  double cell = 0.0;
  std::vector<double> value;  ///< exactly 0 on the surface, where a point may have moved
  std::vector<Vector3> p;     ///< where the point is now

  [[nodiscard]] std::int32_t corner(std::int32_t i, std::int32_t j, std::int32_t k) const {
    return (k * (cubes[1] + 1) + j) * (cubes[0] + 1) + i;
  }
  [[nodiscard]] std::int32_t centre(std::int32_t i, std::int32_t j, std::int32_t k) const {
    return corners + (k * cubes[1] + j) * cubes[0] + i;
  }
  /// Place of a point before it moved, in halves of a cube.
  [[nodiscard]] std::array<std::int32_t, 3> halves(std::int32_t point) const {
    const std::int32_t odd = point < corners ? 0 : 1;
    const std::int32_t nx = cubes[0] + 1 - odd;
    const std::int32_t ny = cubes[1] + 1 - odd;
    const std::int32_t rest = odd == 0 ? point : point - corners;
    const std::int32_t row = rest / nx;
    return {2 * (rest % nx) + odd, 2 * (row % ny) + odd, 2 * (row / ny) + odd};
  }
};

Lattice make_lattice(const ImplicitFunction& function, const ImplicitMeshOptions& options) {
  Lattice lattice;
  lattice.cell = options.cell;
  lattice.low = options.low;
  double cells = 1.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double count = std::ceil((options.high[a] - options.low[a]) / options.cell);
    cells *= count;
    if (!(count >= 3.0) || !(cells <= kMaxCells)) {
      throw std::invalid_argument("mesh_implicit: cell too large or too small for the box");
    }
    lattice.cubes[axis] = static_cast<std::int32_t>(count);
  }
  lattice.corners = (lattice.cubes[0] + 1) * (lattice.cubes[1] + 1) * (lattice.cubes[2] + 1);
  const std::int32_t points =
      lattice.corners + lattice.cubes[0] * lattice.cubes[1] * lattice.cubes[2];
  for (std::int32_t point = 0; point < points; ++point) {
    const std::array<std::int32_t, 3> halves = lattice.halves(point);
    const Vector3 steps(halves[0], halves[1], halves[2]);
    lattice.p.emplace_back(lattice.low + (0.5 * lattice.cell) * steps);
    const double value = function(lattice.p.back());
    bool rim = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rim = rim || halves[axis] <= 1 || halves[axis] >= 2 * lattice.cubes[axis] - 1;
    }
    if (!(value > 0.0) && rim) {
      throw std::invalid_argument("mesh_implicit: the solid reaches the box");
    }
    lattice.value.push_back(value);
  }
  return lattice;
}

/// Calls visit(a, b, c, d) for every tetrahedron: two neighbouring centres and an edge of the face
/// between their cubes.
template <typename Visit>
void for_each_tetrahedron(const Lattice& lattice, const Visit& visit) {
  const auto& n = lattice.cubes;
  for (std::int32_t k = 0; k < n[2]; ++k) {
    for (std::int32_t j = 0; j < n[1]; ++j) {
      for (std::int32_t i = 0; i < n[0]; ++i) {
        const std::int32_t a = lattice.centre(i, j, k);
        const auto side = [&](std::int32_t b, const std::array<std::int32_t, 4>& ring) {
          for (std::size_t m = 0; m < 4; ++m) visit(a, b, ring[m], ring[(m + 1) % 4]);
        };
        const auto corner = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
          return lattice.corner(i + x, j + y, k + z);
        };
        if (i + 1 < n[0]) {
          side(lattice.centre(i + 1, j, k),
               {corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1)});
        }
        if (j + 1 < n[1]) {
          side(lattice.centre(i, j + 1, k),
               {corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0)});
        }
        if (k + 1 < n[2]) {
          side(lattice.centre(i, j, k + 1),
               {corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)});
        }
      }
    }
  }
}

/// Neighbours of all points in a crossed tetrahedron, each once, with increasing index.
std::vector<Edge> crossed_edges(const Lattice& lattice) {
  std::vector<Edge> edges;
  const auto add = [&](std::int32_t a, std::int32_t b) {
    if ((lattice.value[at(a)] < 0.0) == (lattice.value[at(b)] < 0.0)) return;
    edges.emplace_back(a, b);
    edges.emplace_back(b, a);
  };
  for_each_tetrahedron(lattice,
                       [&](std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
                         add(a, b);
                         add(a, c);
                         add(a, d);
                         add(b, c);
                         add(b, d);
                         add(c, d);
                       });
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// Share of the way from a to b where the function crosses zero, taken as linear.
double crossing(const Lattice& lattice, std::int32_t a, std::int32_t b) {
  return lattice.value[at(a)] / (lattice.value[at(a)] - lattice.value[at(b)]);
}

/// Moves points onto the surface, one after the other: what has moved ends its edges' crossings.
void snap(Lattice& lattice) {
  const std::vector<Edge> edges = crossed_edges(lattice);
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    const std::int32_t a = edges[begin].first;
    double nearest = 1.0;
    Vector3 p_nearest{0.0, 0.0, 0.0};
    for (end = begin; end < edges.size() && edges[end].first == a; ++end) {
      const std::int32_t b = edges[end].second;
      if (lattice.value[at(b)] == 0.0) continue;
      const double share = crossing(lattice, a, b);
      const bool long_edge = (a < lattice.corners) == (b < lattice.corners);
      const double relative = share / (long_edge ? kSnapLong : kSnapShort);
      if (relative >= nearest) continue;
      nearest = relative;
      p_nearest = lattice.p[at(a)] + share * (lattice.p[at(b)] - lattice.p[at(a)]);
    }
    if (nearest >= 1.0) continue;
    lattice.p[at(a)] = p_nearest;
    lattice.value[at(a)] = 0.0;
  }
}

/// Triangles whose corners are crossed edges; a moved point counts as outside and stands for all
/// edges from it, as {point, point}.
class Surface {
 public:
  explicit Surface(const Lattice& lattice) : lattice_(lattice) {}

  void add_tetrahedron(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    std::array<std::int32_t, 4> points{a, b, c, d};
    std::stable_partition(points.begin(), points.end(),
                          [&](std::int32_t i) { return lattice_.value[at(i)] < 0.0; });
    const auto inside = std::count_if(points.begin(), points.end(),
                                      [&](std::int32_t i) { return lattice_.value[at(i)] < 0.0; });
    const auto& q = points;
    if (inside == 1) add_triangle({{{q[0], q[1]}, {q[0], q[2]}, {q[0], q[3]}}});
    if (inside == 3) add_triangle({{{q[0], q[3]}, {q[1], q[3]}, {q[2], q[3]}}});
    if (inside == 2) {
      add_triangle({{{q[0], q[2]}, {q[0], q[3]}, {q[1], q[3]}}});
      add_triangle({{{q[0], q[2]}, {q[1], q[3]}, {q[1], q[2]}}});
    }
  }

  [[nodiscard]] TriangleMesh mesh() {
    cancel_opposites();
    std::vector<Edge> corners;
    for (const auto& triangle : triangles_) {
      corners.insert(corners.end(), triangle.begin(), triangle.end());
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    TriangleMesh mesh;
    for (const auto& [a, b] : corners) {
      const double share = a == b ? 0.0 : crossing(lattice_, a, b);
      mesh.vertices.emplace_back(lattice_.p[at(a)] +
                                 share * (lattice_.p[at(b)] - lattice_.p[at(a)]));
    }
    for (const auto& triangle : triangles_) {
      Triangle indices{};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto place = std::lower_bound(corners.begin(), corners.end(), triangle[k]);
        indices[k] = static_cast<std::int32_t>(place - corners.begin());
      }
      mesh.triangles.push_back(indices);
    }
    return mesh;
  }

 private:
  /// Where moved points leave a gap without width between two tetrahedra inside, both closed it:
  /// the two triangles, opposite to each other, go.
  void cancel_opposites() {
    std::vector<std::pair<std::array<Edge, 3>, std::size_t>> sorted;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      std::array<Edge, 3> corners = triangles_[i];
      std::sort(corners.begin(), corners.end());
      sorted.emplace_back(corners, i);
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<bool> dropped(triangles_.size(), false);
    for (std::size_t k = 1; k < sorted.size(); ++k) {
      if (sorted[k].first != sorted[k - 1].first) continue;
      dropped[sorted[k].second] = true;
      dropped[sorted[k - 1].second] = true;
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (!dropped[i]) triangles_[kept++] = triangles_[i];
    }
    triangles_.resize(kept);
  }

  /// Corners as {inside, outside}.
  void add_triangle(std::array<Edge, 3> corners) {
    // Orientation from the lattice before points moved, where nothing is degenerate.
    std::array<Vector3, 3> middle;
    Vector3 outward{0.0, 0.0, 0.0};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 p_in = original(corners[k].first);
      const Vector3 p_out = original(corners[k].second);
      middle[k] = p_in + p_out;
      outward += p_out - p_in;
      if (lattice_.value[at(corners[k].second)] == 0.0) corners[k].first = corners[k].second;
    }
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) return;
    const Vector3 normal = (middle[1] - middle[0]).cross(middle[2] - middle[0]);
    if (dot(normal, outward) < 0.0) std::swap(corners[1], corners[2]);
    triangles_.push_back(corners);
  }

  [[nodiscard]] Vector3 original(std::int32_t point) const {
    const std::array<std::int32_t, 3> halves = lattice_.halves(point);
    return Vector3(halves[0], halves[1], halves[2]);
  }

  const Lattice& lattice_;
  std::vector<std::array<Edge, 3>> triangles_;
};

/// Newton's way to the level, along the gradient.
Vector3 on_level(const ImplicitFunction& function, Vector3 p, double cell) {
  const double h = kDifference * cell;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const double value = function(p);
    Vector3 slope{0.0, 0.0, 0.0};
    for (int axis = 0; axis < 3; ++axis) {
      Vector3 before = p;
      Vector3 after = p;
      before[axis] -= h;
      after[axis] += h;
      slope[axis] = (function(after) - function(before)) / (2.0 * h);
    }
    const double square = dot(slope, slope);
    // A flat function gives no direction.
    if (!(square > 1e-6)) break;
    // No further than the lattice knows the surface to be.
    const double length = std::fabs(value) / std::sqrt(square);
    const double share = std::min(1.0, cell / std::max(length, 1e-300));
    p -= slope * (share * value / square);
  }
  return p;
}

void even_out(const ImplicitFunction& function, TriangleMesh& mesh, double cell) {
  std::vector<Vector3> sum(mesh.vertices.size(), Vector3{0.0, 0.0, 0.0});
  std::vector<int> count(mesh.vertices.size(), 0);
  // In a closed mesh each neighbour is met once as the next corner of a triangle.
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum[at(t[k])] += mesh.vertices[at(t[(k + 1) % 3])];
      ++count[at(t[k])];
    }
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3 mean = sum[i] / count[i];
    Vector3& p = mesh.vertices[i];
    p = on_level(function, p + kEvening * (mean - p), cell);
  }
}

}  // namespace

TriangleMesh mesh_implicit(const ImplicitFunction& function, const ImplicitMeshOptions& options) {
  if (!(options.cell > 0.0) || options.rounds < 0) {
    throw std::invalid_argument("mesh_implicit: cell must be > 0 and rounds >= 0");
  }
  Lattice lattice = make_lattice(function, options);
  snap(lattice);
  Surface surface(lattice);
  for_each_tetrahedron(lattice, [&](std::int32_t a, std::int32_t b, std::int32_t c,
                                    std::int32_t d) { surface.add_tetrahedron(a, b, c, d); });
  TriangleMesh mesh = surface.mesh();
  for (Vector3& p : mesh.vertices) p = on_level(function, p, options.cell);
  for (int round = 0; round < options.rounds; ++round) even_out(function, mesh, options.cell);
  return mesh;
}

}  // namespace hapticd
