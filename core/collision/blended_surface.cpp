// The leaves within reach of the blend, and the equation of phi. See blended_surface.h. RT: yes.
#include "core/collision/blended_surface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "core/collision/descent.h"
#include "core/collision/node_kernels.h"
#include "core/collision/obstacles.h"
#include "core/math/cpu.h"

namespace hapticd {
namespace {

/// Steps of Newton's method, which comes down onto phi: six reach the rounding.
constexpr int kMaxNewton = 16;
/// A step of Newton's below this share of the width is rounding.
constexpr double kNewtonRounding = 1e-15;

/// A leaf near the point.
struct NearLeaf {
  TreeSphereId id;
  Vector3 offset;   ///< from its centre to the point, m
  double distance;  ///< |offset|, m
  double gap;       ///< distance less the radius, m
};

/// The leaves that may have a share.
struct NearLeaves {
  explicit NearLeaves(double width_of_blend) noexcept : width(width_of_blend) {}

  double width;                                            ///< of the blend, m
  double least = std::numeric_limits<double>::infinity();  ///< smallest gap, or a bound of it, m
  std::size_t count = 0;
  std::int64_t tests = 0;
  std::array<NearLeaf, kMaxBlended> leaf;

  [[nodiscard]] double reach() const noexcept { return least + width; }

  void add(const NearLeaf& near) noexcept {
    if (!(near.gap < reach())) return;
    least = std::min(least, near.gap);
    if (count == kMaxBlended) drop();
    if (count < kMaxBlended) leaf[count++] = near;
  }

 private:
  /// Drops those that are out of reach by now, or else the farthest.
  void drop() noexcept {
    const auto end = std::remove_if(leaf.begin(), leaf.end(),
                                    [this](const NearLeaf& near) { return !(near.gap < reach()); });
    count = static_cast<std::size_t>(end - leaf.begin());
    if (count < kMaxBlended) return;
    const auto farthest =
        std::max_element(leaf.begin(), leaf.end(),
                         [](const NearLeaf& a, const NearLeaf& b) { return a.gap < b.gap; });
    std::move(farthest + 1, leaf.end(), farthest);
    --count;
  }
};

NearLeaf leaf_beside(const SphereTreeNode& node, std::size_t k, const Vector3& p_B) noexcept {
  const Vector3 offset = p_B - Vector3(node.x[k], node.y[k], node.z[k]);
  const double distance = length(offset);
  return {~node.child[k], offset, distance, distance - node.r[k]};
}

/// Gap of the leaf where always taking the nearest child ends, m.
template <typename Kernels>
double gap_of_dive(const SphereTreeView& tree, const SphereProbe& probe,
                   std::int64_t& tests) noexcept {
  for (std::size_t n = 0;;) {
    const SphereTreeNode& node = tree.nodes[n];
    Lanes lower;
    Kernels::bounds(lanes_of(node), probe, lower);
    tests += kTreeWidth;
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
  out.least = gap_of_dive<Kernels>(tree, probe, out.tests);
  DescentStack<std::int32_t, kMaxTreeDepth*(kTreeWidth - 1) + 1> stack;
  stack.push(0);
  while (!stack.empty()) {
    const SphereTreeNode& node = tree.nodes[static_cast<std::size_t>(stack.pop())];
    const unsigned near = Kernels::near(lanes_of(node), probe, out.reach());
    out.tests += kTreeWidth;
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
}

using Shares = std::array<double, kMaxBlended>;

/// The shares s_i = 1 - (d_i - phi) / w of the leaves, those out of reach 0; phi is returned. From
/// above, where the sum of cubes is convex in phi.
double solve(const NearLeaves& near, Shares& share) noexcept {
  double below = 0.0;  // phi less the smallest gap
  for (int i = 0; i < kMaxNewton; ++i) {
    double cubes = 0.0;
    double squares = 0.0;
    for (std::size_t k = 0; k < near.count; ++k) {
      const double s = (near.reach() - near.leaf[k].gap + below) / near.width;
      share[k] = s > 0.0 ? s : 0.0;
      squares += share[k] * share[k];
      cubes += share[k] * share[k] * share[k];
    }
    const double step = (cubes - 1.0) * near.width / (3.0 * squares);
    if (!(step > kNewtonRounding * near.width)) break;
    below -= step;
  }
  return near.least + below;
}

}  // namespace

void find_shares(const SphereTreeView& tree, const Vector3& p_B, BlendShares& out) noexcept {
  NearLeaves near(tree.blend.width);
  find_leaves(tree, p_B, near);
  Shares share;
  out.distance = solve(near, share);
  double squares = 0.0;
  for (std::size_t k = 0; k < near.count; ++k) squares += share[k] * share[k];
  out.count = near.count;
  for (std::size_t k = 0; k < near.count; ++k) {
    out.share[k] = {near.leaf[k].id, share[k] * share[k] / squares};
  }
}

BlendedPlace place_beside_blend(const SphereTreeView& tree, const Vector3& p_B) noexcept {
  NearLeaves near(tree.blend.width);
  find_leaves(tree, p_B, near);
  BlendedPlace place;
  place.tests = near.tests;
  Shares share;
  place.distance = solve(near, share);

  double squares = 0.0;
  Vector3 gradient = Vector3::Zero();
  for (std::size_t k = 0; k < near.count; ++k) squares += share[k] * share[k];
  for (std::size_t k = 0; k < near.count; ++k) {
    const NearLeaf& leaf = near.leaf[k];
    if (leaf.distance < kMinLength) continue;
    gradient += leaf.offset * (share[k] * share[k] / (squares * leaf.distance));
  }
  const double steepness = length(gradient);
  place.nhat_B = Vector3::Zero();
  if (steepness < kMinLength) return place;
  place.nhat_B = gradient * (1.0 / steepness);

  // Half the trace of the second derivative across the normal: the leaves' own curvature, less what
  // the spread of their normals rounds off.
  double bulge = 0.0;
  for (std::size_t k = 0; k < near.count; ++k) {
    const NearLeaf& leaf = near.leaf[k];
    if (share[k] == 0.0 || leaf.distance < kMinLength) continue;
    const Vector3 n = leaf.offset * (1.0 / leaf.distance);
    const double along = n.dot(place.nhat_B);
    const Vector3 spread = n - gradient;
    const double spread_along = spread.dot(place.nhat_B);
    bulge += share[k] * share[k] * (1.0 + along * along) / leaf.distance -
             2.0 * share[k] * (spread.squaredNorm() - spread_along * spread_along) / near.width;
  }
  place.curvature = bulge / (2.0 * squares * steepness);
  return place;
}

}  // namespace hapticd
