// See surface_patches.h.
#include "server/model/packing/surface_patches.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <stdexcept>

#include "core/geometry/closest_point.h"
#include "core/math/elementary.h"
#include "server/model/packing/counter_random.h"
#include "server/model/packing/inner_ball.h"
#include "server/model/packing/parallel_chunks.h"

namespace hapticd {
namespace {

/// Patches in a leaf of the tree. Normal value 16: balls that matter for a leaf are looked up once
/// for all.
constexpr std::int32_t kLeafPatches = 16;
/// Triangles per chunk of work.
constexpr std::int64_t kChunk = 64;
/// Share of the bound that balls may stick out where the reach is measured.
constexpr double kSlack = 0.5;
/// A piece up to this many times the wanted size is not measured again when it is divided. Normal
/// value 4; less takes longer, more misses changes of the reach.
constexpr double kInherit = 4.0;
/// Corners are measured this share of the way to the centroid, off the edges of the mesh.
constexpr double kPull = 0.1;
/// A piece of this share of the wanted size at its centroid is not measured at its corners.
constexpr double kSurelySmall = 0.5;
/// Samples of an estimate.
constexpr std::uint64_t kEstimateSamples = 4000;

/// Radius of the disc of a plane that a ball of radius `r` covers when it sticks out by `bound`.
double disc_radius(double r, double bound) { return std::sqrt(2.0 * r * bound + bound * bound); }

struct Piece {
  Vector3 a, b, c;
  double reach;  ///< 0: to be measured
};

struct Divider {
  const MeshDistance& distance;
  PatchOptions options;
  double extent;

  double reach_at(const Vector3& p, const Vector3& normal) const {
    const Sphere ball = inner_ball(distance, p, normal, {kSlack * options.bound, extent});
    return disc_radius(ball.r, options.bound);
  }

  double reach_of(const Piece& piece, const Vector3& normal, double longest) const {
    const Vector3 middle = (piece.a + piece.b + piece.c) / 3.0;
    double least = reach_at(middle, normal);
    if (longest <= kSurelySmall * options.size * least) return least;
    for (const Vector3* corner : {&piece.a, &piece.b, &piece.c}) {
      least = std::min(least, reach_at(*corner + kPull * (middle - *corner), normal));
    }
    return least;
  }

  void divide(const Piece& whole, std::atomic<std::int64_t>& total,
              std::vector<Patch>& found) const;
};

/// Both halves of `piece`, cut across its longest side.
std::array<Piece, 2> halves(const Piece& piece, double& longest) {
  const double ab = length(piece.b - piece.a);
  const double bc = length(piece.c - piece.b);
  const double ca = length(piece.a - piece.c);
  longest = std::max(ab, std::max(bc, ca));
  Piece t = piece;
  if (bc == longest) {
    t = {piece.b, piece.c, piece.a, piece.reach};
  } else if (ca == longest) {
    t = {piece.c, piece.a, piece.b, piece.reach};
  }
  const Vector3 middle = 0.5 * (t.a + t.b);
  return {{{t.a, middle, t.c, t.reach}, {middle, t.b, t.c, t.reach}}};
}

void Divider::divide(const Piece& whole, std::atomic<std::int64_t>& total,
                     std::vector<Patch>& found) const {
  const Vector3 across = (whole.b - whole.a).cross(whole.c - whole.a);
  const double twice = length(across);
  // Without area it lies on the sides of its neighbours, which are covered.
  if (!(twice > 0.0)) return;
  const Vector3 normal = across / twice;
  std::vector<Piece> rest{whole};
  while (!rest.empty()) {
    Piece piece = rest.back();
    rest.pop_back();
    double longest = 0.0;
    const std::array<Piece, 2> parts = halves(piece, longest);
    if (piece.reach <= 0.0) piece.reach = reach_of(piece, normal, longest);
    const double wanted = options.size * piece.reach;
    if (longest <= wanted) {
      const double area = 0.5 * length((piece.b - piece.a).cross(piece.c - piece.a));
      found.push_back({piece.a, piece.b, piece.c, normal, area, piece.reach});
      if (++total > kMaxPatches) {
        throw std::runtime_error("sphere packing: the bound is too small for this mesh");
      }
      continue;
    }
    for (Piece part : parts) {
      part.reach = longest > kInherit * wanted ? 0.0 : piece.reach;
      rest.push_back(part);
    }
  }
}

void build_tree(SurfacePatches& surface) {
  std::vector<Patch>& patches = surface.patches;
  const Vector3 zero(0.0, 0.0, 0.0);
  surface.nodes.push_back({zero, zero, 0, static_cast<std::int32_t>(patches.size()), 0});
  for (std::size_t n = 0; n < surface.nodes.size(); ++n) {
    PatchNode node = surface.nodes[n];
    const auto begin = patches.begin() + node.first;
    const auto end = begin + node.count;
    node.low = node.high = begin->a;
    for (auto i = begin; i != end; ++i) {
      node.low = node.low.cwiseMin(i->a).cwiseMin(i->b).cwiseMin(i->c);
      node.high = node.high.cwiseMax(i->a).cwiseMax(i->b).cwiseMax(i->c);
    }
    if (node.count > kLeafPatches) {
      const Vector3 extent = node.high - node.low;
      int axis = extent.y() > extent.x() ? 1 : 0;
      if (extent.z() > extent[axis]) axis = 2;
      const std::int32_t left = node.count / 2;
      // A total order as far as anyone can tell: patches equal in all three sums are told apart by
      // nothing that matters.
      std::nth_element(begin, begin + left, end, [&](const Patch& s, const Patch& t) {
        for (int k = 0; k < 3; ++k) {
          const int i = (axis + k) % 3;
          const double ps = s.a[i] + s.b[i] + s.c[i];
          const double pt = t.a[i] + t.b[i] + t.c[i];
          if (ps != pt) return ps < pt;
        }
        return false;
      });
      node.child = static_cast<std::int32_t>(surface.nodes.size());
      surface.nodes.push_back({zero, zero, node.first, left, 0});
      surface.nodes.push_back({zero, zero, node.first + left, node.count - left, 0});
    }
    surface.nodes[n] = node;
  }
  std::vector<std::int32_t> rest{0};
  while (!rest.empty()) {
    const std::int32_t n = rest.back();
    rest.pop_back();
    const PatchNode& node = surface.nodes[static_cast<std::size_t>(n)];
    if (node.child == 0) {
      surface.leaves.push_back(n);
      continue;
    }
    rest.push_back(node.child + 1);
    rest.push_back(node.child);
  }
}

}  // namespace

double mesh_extent(const TriangleMesh& mesh) {
  Vector3 low = mesh.vertices.front();
  Vector3 high = low;
  for (const Vector3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return (high - low).maxCoeff();
}

double estimated_balls(const TriangleMesh& mesh, const MeshDistance& distance, double bound) {
  const Divider divider{distance, {bound, 0.25, 1}, mesh_extent(mesh)};
  std::vector<double> sums;
  double total = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, t);
    sums.push_back(total += 0.5 * length((b - a).cross(c - a)));
  }
  double count = 0.0;
  for (std::uint64_t k = 0; k < kEstimateSamples; ++k) {
    const double place = (static_cast<double>(k) + 0.5) / kEstimateSamples * total;
    const auto it = std::upper_bound(sums.begin(), sums.end() - 1, place);
    const auto [a, b, c] =
        corners(mesh, mesh.triangles[static_cast<std::size_t>(it - sums.begin())]);
    const Vector3 across = (b - a).cross(c - a);
    const double twice = length(across);
    if (!(twice > 0.0)) continue;
    const double root = std::sqrt(counter_uniform(1, 2 * k));
    const double other = root * counter_uniform(1, 2 * k + 1);
    const Vector3 p = (1.0 - root) * a + (root - other) * b + other * c;
    const double reach = divider.reach_at(p, across / twice);
    count += total / kEstimateSamples / (kPi * reach * reach);
  }
  return count;
}

SurfacePatches divide_surface(const TriangleMesh& mesh, const MeshDistance& distance,
                              const PatchOptions& options) {
  const Divider divider{distance, options, mesh_extent(mesh)};
  const auto count = static_cast<std::int64_t>(mesh.triangles.size());
  std::vector<std::vector<Patch>> found(static_cast<std::size_t>(chunk_count(count, kChunk)));
  std::atomic<std::int64_t> total{0};
  for_chunks(count, kChunk, options.threads,
             [&](std::int64_t chunk, std::int64_t begin, std::int64_t end) {
               for (std::int64_t i = begin; i < end; ++i) {
                 const auto [a, b, c] = corners(mesh, mesh.triangles[static_cast<std::size_t>(i)]);
                 divider.divide({a, b, c, 0.0}, total, found[static_cast<std::size_t>(chunk)]);
               }
             });
  if (total == 0) throw std::invalid_argument("sphere packing: the mesh has no area");
  SurfacePatches surface;
  surface.patches.reserve(static_cast<std::size_t>(total.load()));
  for (std::vector<Patch>& part : found) {
    surface.patches.insert(surface.patches.end(), part.begin(), part.end());
    part = {};
  }
  build_tree(surface);
  return surface;
}

}  // namespace hapticd
