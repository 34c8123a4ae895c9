// The smallest gap between the tool and the obstacles, by branch and bound: parts that cannot
// improve on the best gap so far are skipped. On a capsule the nearest bounds come first; on a body
// the search starts from the gap of a pair that is likely to be near. RT: yes.
#pragma once

#include <algorithm>

#include "core/collision/body_descent.h"

namespace hapticd {

/// The search's state over all obstacles.
struct NearestGap {
  double gap;              ///< smallest found so far, or the horizon, m
  std::int64_t tests = 0;  ///< bounds and spheres evaluated
};

/// Parts found in one step, with their lower bounds, farthest first.
template <typename T>
class FarthestFirst {
 public:
  struct Entry {
    T part;
    double lower;
  };
  void insert(const T& part, double lower) noexcept {
    std::size_t k = count_++;
    for (; k > 0 && entries_[k - 1].lower < lower; --k) entries_[k] = entries_[k - 1];
    entries_[k] = {part, lower};
  }
  [[nodiscard]] const Entry* begin() const noexcept { return entries_.data(); }
  [[nodiscard]] const Entry* end() const noexcept { return entries_.data() + count_; }

 private:
  std::size_t count_ = 0;
  std::array<Entry, kTreeWidth> entries_;
};

/// Bits of the lanes below `limit`.
[[nodiscard]] inline unsigned lanes_below(const Lanes& lower, double limit) noexcept {
  unsigned mask = 0;
  for (std::size_t k = 0; k < lower.size(); ++k) {
    mask |= static_cast<unsigned>(lower[k] < limit) << k;
  }
  return mask;
}

/// Smallest of the lanes in `mask`, which is not 0.
[[nodiscard]] inline double smallest(const Lanes& lanes, unsigned mask) noexcept {
  double result = std::numeric_limits<double>::infinity();
  for (; mask != 0; mask &= mask - 1) {
    const double value = lanes[static_cast<std::size_t>(std::countr_zero(mask))];
    result = value < result ? value : result;
  }
  return result;
}

/// Lowers `nearest` to the gap of the tool to `capsule_W`.
template <typename Kernels>
void nearest_on_capsule(const LevelledTree& tool, const ToolPlacement& placement,
                        const Capsule& capsule_W, NearestGap& nearest) noexcept {
  const PlacedCapsule capsule = place_capsule(capsule_W, placement.p_WG);
  const CapsuleProbe probe = probe_capsule(capsule, placement.R_WG, reach(tool.tree),
                                           surface_overhang(tool.tree, tool.last_level));
  using Found = FarthestFirst<TreePart>;
  DescentStack<Found::Entry, kMaxTreeDepth * kTreeWidth> stack;
  CapsuleGaps gaps;
  stack.push({LevelledTree::root(), -std::numeric_limits<double>::infinity()});
  while (!stack.empty()) {
    const auto [part, bound] = stack.pop();
    if (!(bound < nearest.gap)) continue;
    const SphereTreeNode& node = tool.node(part);
    nearest.tests += kTreeWidth;
    if (const unsigned surface = tool.surface(part); surface != 0) {
      const unsigned hit =
          Kernels::capsule_gaps(node, surface, placement.R_WG, capsule, nearest.gap, gaps);
      nearest.gap = std::min(nearest.gap, smallest(gaps.lanes.gap, hit));
    }
    const unsigned inner = tool.inner(part);
    if (inner == 0) continue;
    Lanes lower;
    Kernels::bounds(lanes_of(node), probe, lower);
    Found found;
    for (unsigned rest = lanes_below(lower, nearest.gap) & inner; rest != 0; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      found.insert(tool.child(part, k), lower[static_cast<std::size_t>(k)]);
    }
    for (const auto& entry : found) stack.push(entry);
  }
}

/// Rounds of dives before the search proper. Normal value 2. Costs only time: the better the first
/// gap, the fewer parts are opened.
inline constexpr int kDives = 2;

/// Lowers a NearestGap to the gaps of the pairs that a BodyDescent finds.
class NearestPair {
 public:
  NearestPair(const PlacedTrees& trees, NearestGap& nearest) noexcept
      : trees_(trees), nearest_(nearest) {}

  [[nodiscard]] double radius() const noexcept { return nearest_.gap; }
  void count_tests(int tests) noexcept { nearest_.tests += tests; }

  void hit(const NodePair& pair, int i, int k, const PointLanes& p_BC) noexcept {
    const SphereTreeNode& tool = trees_.tool.node(pair.tool.part);
    const SphereTreeNode& body = trees_.body.node(pair.body.part);
    const auto row = static_cast<std::size_t>(i);
    const auto lane = static_cast<std::size_t>(k);
    const PrimitiveGap gap = gap_to_body_sphere(
        p_BC[row], tool.r[row], {{body.x[lane], body.y[lane], body.z[lane]}, body.r[lane]});
    nearest_.gap = std::min(nearest_.gap, gap.gap);
  }

 private:
  const PlacedTrees& trees_;
  NearestGap& nearest_;
};

/// The surface sphere where always taking the child nearest to `probe` ends.
template <typename Kernels>
[[nodiscard]] Sphere dive(const LevelledTree& tree, const Vector3& probe,
                          std::int64_t& tests) noexcept {
  TreePart part = LevelledTree::root();
  for (;;) {
    const SphereTreeNode& node = tree.node(part);
    Lanes lower;
    Kernels::bounds(lanes_of(node), SphereProbe{probe, 0.0}, lower);
    tests += kTreeWidth;
    const auto k =
        static_cast<std::size_t>(std::min_element(lower.begin(), lower.end()) - lower.begin());
    if ((tree.inner(part) >> k & 1U) == 0) return {{node.x[k], node.y[k], node.z[k]}, node.r[k]};
    part = tree.child(part, static_cast<int>(k));
  }
}

/// Gap of a pair that is probably among the nearest: each sphere the nearest to the other, in turn.
template <typename Kernels>
[[nodiscard]] double gap_of_dives(const PlacedTrees& trees, std::int64_t& tests) noexcept {
  const PlacedBody& placement = trees.placement;
  const Matrix3 R_GB = placement.R_BG.transpose();
  Vector3 p_BC = to_body(placement, trees.tool.tree.bound.p);
  double gap = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kDives; ++k) {
    const Sphere body = dive<Kernels>(trees.body, p_BC, tests);
    const Sphere tool = dive<Kernels>(trees.tool, rotate(R_GB, body.p - placement.p_BG), tests);
    p_BC = to_body(placement, tool.p);
    gap = std::min(gap, gap_to_body_sphere(p_BC, tool.r, body).gap);
  }
  return gap;
}

/// Lowers `nearest` to the gap of the tool to a body.
template <typename Kernels>
void nearest_on_body(const PlacedTrees& trees, NearestGap& nearest) noexcept {
  const Sphere& bound_G = trees.tool.tree.bound;
  const PrimitiveGap bounds =
      gap_to_body_sphere(to_body(trees.placement, bound_G.p), bound_G.r, trees.body.tree.bound);
  if (bounds.gap - trees.slack > nearest.gap) return;
  nearest.gap = std::min(nearest.gap, gap_of_dives<Kernels>(trees, nearest.tests));
  NearestPair visitor(trees, nearest);
  BodyDescent<Kernels, NearestPair>(trees, visitor).run();
}

}  // namespace hapticd
