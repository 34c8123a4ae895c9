// The leaves within reach of the blend, and the equation of phi. See blended_surface.h. RT: yes.
#include "core/collision/blended_surface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/collision/descent.h"
#include "core/collision/node_kernels.h"
#include "core/collision/obstacles.h"
#include "core/math/cpu.h"

namespace hapticd {
namespace {

/// Steps of Halley's method: four reach the rounding.
constexpr int kMaxSteps = 16;
/// A step below this, in widths, is rounding.
constexpr double kRounding = 1e-15;
/// How far from where leaves are looked for they are used again, as a share of the width. More:
/// more leaves that have no share; less: looked for more often.
constexpr double kAround = 0.25;

/// A leaf and how far a point is from it.
struct NearLeaf {
  TreeSphereId id;
  double gap;  ///< m
  Sphere sphere;
};

double gap_of(const Sphere& leaf, const Vector3& p_B) noexcept {
  return length(p_B - leaf.p) - leaf.r;
}

/// The leaves whose gaps are less than `beyond` above the smallest.
struct NearLeaves {
  explicit NearLeaves(double beyond_the_least) noexcept : beyond(beyond_the_least) {}

  double beyond;                                           ///< m
  double least = std::numeric_limits<double>::infinity();  ///< smallest gap, or a bound of it, m
  std::size_t count = 0;
  std::array<NearLeaf, kMaxBlended> leaf;

  [[nodiscard]] double reach() const noexcept { return least + beyond; }

  void add(const NearLeaf& near) noexcept {
    if (!(near.gap < reach())) return;
    least = std::min(least, near.gap);
    if (count == kMaxBlended) drop();
    leaf[count++] = near;
  }

  /// Leaves those within reach alone, in ascending order, so that sums do not depend on the way.
  void finish() noexcept {
    drop_far();
    std::sort(leaf.begin(), leaf.begin() + static_cast<std::ptrdiff_t>(count),
              [](const NearLeaf& a, const NearLeaf& b) { return a.id < b.id; });
  }

 private:
  void drop_far() noexcept {
    const auto all = leaf.begin() + static_cast<std::ptrdiff_t>(count);
    const auto end = std::remove_if(leaf.begin(), all,
                                    [this](const NearLeaf& near) { return !(near.gap < reach()); });
    count = static_cast<std::size_t>(end - leaf.begin());
  }
  /// Drops those that are out of reach by now, or else the farthest.
  void drop() noexcept {
    drop_far();
    if (count < kMaxBlended) return;
    const auto farthest =
        std::max_element(leaf.begin(), leaf.end(),
                         [](const NearLeaf& a, const NearLeaf& b) { return a.gap < b.gap; });
    std::move(farthest + 1, leaf.end(), farthest);
    --count;
  }
};

NearLeaf leaf_beside(const SphereTreeNode& node, std::size_t k, const Vector3& p_B) noexcept {
  const Sphere sphere{{node.x[k], node.y[k], node.z[k]}, node.r[k]};
  return {~node.child[k], gap_of(sphere, p_B), sphere};
}

/// Gap of the leaf where always taking the nearest child ends, m.
template <typename Kernels>
double gap_of_dive(const SphereTreeView& tree, const SphereProbe& probe) noexcept {
  for (std::size_t n = 0;;) {
    const SphereTreeNode& node = tree.nodes[n];
    Lanes lower;
    Kernels::bounds(lanes_of(node), probe, lower);
    const auto k =
        static_cast<std::size_t>(std::min_element(lower.begin(), lower.end()) - lower.begin());
    if ((node.inner >> k & 1U) == 0) return leaf_beside(node, k, probe.p).gap;
    n = static_cast<std::size_t>(node.child[k]);
  }
}

/// False when nothing below the node is certainly within `radius` (m).
bool may_reach(const SphereTreeView& tree, std::int32_t node, const Vector3& p_B,
               double radius) noexcept {
  if (tree.boxes.empty() || !(radius > 0.0)) return true;
  const NodeBox& box = tree.boxes[static_cast<std::size_t>(node)];
  return may_touch({box.lower, box.upper}, {p_B, radius});
}

template <typename Kernels>
void find_leaves(const SphereTreeView& tree, const SphereProbe& probe, NearLeaves& out) noexcept {
  out.least = gap_of_dive<Kernels>(tree, probe);
  DescentStack<std::int32_t, kMaxTreeDepth*(kTreeWidth - 1) + 1> stack;
  stack.push(0);
  while (!stack.empty()) {
    const SphereTreeNode& node = tree.nodes[static_cast<std::size_t>(stack.pop())];
    const unsigned near = Kernels::near(lanes_of(node), probe, out.reach());
    for (unsigned rest = near & ~node.inner; rest != 0; rest &= rest - 1) {
      out.add(leaf_beside(node, static_cast<std::size_t>(std::countr_zero(rest)), probe.p));
    }
    for (unsigned rest = near & node.inner; rest != 0; rest &= rest - 1) {
      const std::int32_t child = node.child[static_cast<std::size_t>(std::countr_zero(rest))];
      if (may_reach(tree, child, probe.p, out.reach() + probe.inflation)) stack.push(child);
    }
  }
}

void find_leaves(const SphereTreeView& tree, const Vector3& p_B, NearLeaves& out) noexcept {
  const SphereProbe probe{p_B, kRelativeSlack * (length(p_B) + reach(tree))};
  if (avx2_available()) {
    find_leaves<Avx2Kernels>(tree, probe, out);
  } else {
    find_leaves<PortableKernels>(tree, probe, out);
  }
  out.finish();
}

/// What of the equation concerns the leaves that have a share.
struct Blend {
  double width;
  double phi;
  std::size_t count = 0;
  double squares = 0.0;  ///< of the shares
  std::array<TreeSphereId, kMaxBlended> id;
  std::array<double, kMaxBlended> x, y, z;  ///< from the leaf's centre, m
  std::array<double, kMaxBlended> distance, gap, share;

  void add(TreeSphereId leaf, const Sphere& sphere, const Vector3& p_B) noexcept {
    const double dx = p_B.x() - sphere.p.x();
    const double dy = p_B.y() - sphere.p.y();
    const double dz = p_B.z() - sphere.p.z();
    const double d = std::sqrt((dx * dx + dy * dy) + dz * dz);
    id[count] = leaf;
    x[count] = dx;
    y[count] = dy;
    z[count] = dz;
    distance[count] = d;
    gap[count++] = d - sphere.r;
  }

  /// Leaves out what has no share, and finds the shares s_i = 1 - (d_i - phi) / w: by Halley's
  /// method, in widths, from the smallest gap down.
  void solve() noexcept {
    const double least = keep_near();
    double below = 0.0;  // phi less the smallest gap
    for (int i = 0; i < kMaxSteps; ++i) {
      double cubes = 0.0;
      double sum = 0.0;
      squares = 0.0;
      for (std::size_t k = 0; k < count; ++k) {
        const double s = gap[k] + below > 0.0 ? gap[k] + below : 0.0;
        share[k] = s;
        sum += s;
        squares += s * s;
        cubes += s * s * s;
      }
      const double excess = cubes - 1.0;
      const double step = excess * squares / (3.0 * squares * squares - excess * sum);
      if (!(std::abs(step) > kRounding)) break;
      below -= step;
    }
    phi = least + width * below;
  }

 private:
  /// Turns gaps into the shares that phi = the smallest gap, which it returns, would give.
  double keep_near() noexcept {
    double least = gap[0];
    for (std::size_t k = 1; k < count; ++k) least = gap[k] < least ? gap[k] : least;
    const double inverse = 1.0 / width;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const double s = 1.0 - (gap[k] - least) * inverse;
      if (!(s > 0.0)) continue;
      id[kept] = id[k];
      x[kept] = x[k];
      y[kept] = y[k];
      z[kept] = z[k];
      distance[kept] = distance[k];
      gap[kept++] = s;
    }
    count = kept;
    return least;
  }
};

/// Whether what is remembered is of the tree.
bool of_tree(const LeavesAround& around, const SphereTreeView& tree) noexcept {
  return around.tree == tree.nodes.data() && around.size == tree.leaf_r.size();
}

/// Whether what is remembered holds for the point.
bool holds(const LeavesAround& around, const SphereTreeView& tree, const Vector3& p_B) noexcept {
  return of_tree(around, tree) && (p_B - around.p_B).squaredNorm() <= around.radius * around.radius;
}

/// Looks for the leaves around the point; false when there are too many to be remembered.
bool look_around(const SphereTreeView& tree, const Vector3& p_B, LeavesAround& out) noexcept {
  const double radius = kAround * tree.blend.width;
  // As the point goes by the radius, one gap grows by that, and the smallest shrinks.
  NearLeaves near(tree.blend.width + 2.0 * radius);
  find_leaves(tree, p_B, near);
  out.tree = nullptr;
  if (near.count > LeavesAround::kCapacity) return false;
  out.tree = tree.nodes.data();
  out.size = tree.leaf_r.size();
  out.p_B = out.p_last_B = p_B;
  out.radius = 0.999 * radius;
  out.count = near.count;
  for (std::size_t k = 0; k < near.count; ++k) {
    out.leaf[k] = near.leaf[k].id;
    out.sphere[k] = near.leaf[k].sphere;
  }
  return true;
}

void blend_at(const SphereTreeView& tree, const Vector3& p_B, LeavesAround* memory,
              Blend& out) noexcept {
  out.width = tree.blend.width;
  if (memory != nullptr && (holds(*memory, tree, p_B) || look_around(tree, p_B, *memory))) {
    for (std::size_t k = 0; k < memory->count; ++k) {
      out.add(memory->leaf[k], memory->sphere[k], p_B);
    }
  } else {
    NearLeaves near(tree.blend.width);
    find_leaves(tree, p_B, near);
    for (std::size_t k = 0; k < near.count; ++k) {
      out.add(near.leaf[k].id, near.leaf[k].sphere, p_B);
    }
  }
  out.solve();
}

/// place_beside_blend() where it is not remembered.
BlendedPlace find_place(const SphereTreeView& tree, const Vector3& p_B,
                        LeavesAround* memory) noexcept {
  Blend blend;
  blend_at(tree, p_B, memory, blend);
  BlendedPlace place;
  place.distance = blend.phi;
  // Of each leaf its share in phi, over its distance.
  std::array<double, kMaxBlended> weight;
  Vector3 gradient = Vector3::Zero();
  const double inverse = 1.0 / blend.squares;
  for (std::size_t k = 0; k < blend.count; ++k) {
    const double d = blend.distance[k];
    weight[k] = d < kMinLength ? 0.0 : blend.share[k] * blend.share[k] * inverse / d;
    gradient.x() += blend.x[k] * weight[k];
    gradient.y() += blend.y[k] * weight[k];
    gradient.z() += blend.z[k] * weight[k];
  }
  const double steepness = length(gradient);
  place.nhat_B = Vector3::Zero();
  if (steepness < kMinLength) return place;
  const Vector3 n = gradient * (1.0 / steepness);
  place.nhat_B = n;

  // Half the trace of the second derivative across the normal: the leaves' own curvature, less what
  // the spread of their normals rounds off.
  double bulge = 0.0;
  const double hollow = 2.0 * inverse / blend.width;
  for (std::size_t k = 0; k < blend.count; ++k) {
    if (weight[k] == 0.0) continue;
    const double along = (blend.x[k] * n.x() + blend.y[k] * n.y()) + blend.z[k] * n.z();
    const double square = along * along / (blend.distance[k] * blend.distance[k]);
    const double across = square < 1.0 ? 1.0 - square : 0.0;
    bulge += weight[k] * (2.0 - across) - hollow * blend.share[k] * across;
  }
  place.curvature = bulge / (2.0 * steepness);
  return place;
}

}  // namespace

void find_shares(const SphereTreeView& tree, const Vector3& p_B, BlendShares& out) noexcept {
  Blend blend;
  blend_at(tree, p_B, nullptr, blend);
  out.distance = blend.phi;
  out.count = blend.count;
  for (std::size_t k = 0; k < blend.count; ++k) {
    out.share[k] = {blend.id[k], blend.share[k] * blend.share[k] / blend.squares};
  }
}

BlendedPlace place_beside_blend(const SphereTreeView& tree, const Vector3& p_B,
                                LeavesAround* memory) noexcept {
  if (memory == nullptr) return find_place(tree, p_B, nullptr);
  if (of_tree(*memory, tree) && p_B == memory->p_last_B) return memory->last;
  const BlendedPlace place = find_place(tree, p_B, memory);
  if (of_tree(*memory, tree)) {
    memory->p_last_B = p_B;
    memory->last = place;
  }
  return place;
}

}  // namespace hapticd
