// The smallest gap between the tool and the obstacles, by branch and bound: nearest bounds first,
// parts that cannot improve on the best gap so far are skipped. RT: yes.
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
  stack.push({tool.root(), -std::numeric_limits<double>::infinity()});
  while (!stack.empty()) {
    const auto [part, bound] = stack.pop();
    if (!(bound < nearest.gap)) continue;
    const SphereTreeNode& node = tool.node(part);
    nearest.tests += kTreeWidth;
    if (part.surface != 0) {
      const unsigned hit =
          Kernels::capsule_gaps(node, part.surface, placement.R_WG, capsule, nearest.gap, gaps);
      nearest.gap = std::min(nearest.gap, smallest(gaps.lanes.gap, hit));
      continue;
    }
    Lanes lower;
    Kernels::bounds(lanes_of(node), probe, lower);
    Found found;
    tool.for_children(
        part, lanes_below(lower, nearest.gap),
        [&](const TreePart& below, unsigned mask) { found.insert(below, smallest(lower, mask)); });
    for (const auto& entry : found) stack.push(entry);
  }
}

/// Lowers `nearest` to the smallest gap of two surface parts.
template <typename Kernels>
void nearest_of_surfaces(const PlacedTrees& trees, const BodyPair& pair,
                         NearestGap& nearest) noexcept {
  const SphereTreeNode& tool = trees.tool.node(pair.tool.part);
  PointLanes p_BC;
  PairGaps gaps;
  Kernels::to_body(tool, trees.placement, p_BC);
  unsigned any = Kernels::pair_gaps({p_BC.x, p_BC.y, p_BC.z, tool.r}, pair.tool.part.surface,
                                    lanes_of(trees.body.node(pair.body.part)),
                                    pair.body.part.surface, nearest.gap, trees.slack, gaps);
  nearest.tests += std::popcount(pair.tool.part.surface) * kTreeWidth;
  for (; any != 0; any &= any - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(any));
    nearest.gap = std::min(nearest.gap, smallest(gaps.lanes[i].gap, gaps.hit[i]));
  }
}

/// Opens one part of `pair` and inserts what may be nearer than `nearest`.
template <typename Kernels>
void open_nearer(const PlacedTrees& trees, const BodyPair& pair, Opening opening,
                 const NearestGap& nearest, FarthestFirst<BodyPair>& found) noexcept {
  Lanes lower;
  if (opening == Opening::kTool) {
    const SphereTreeNode& node = trees.tool.node(pair.tool.part);
    PointLanes p_BC;
    Kernels::to_body(node, trees.placement, p_BC);
    const SphereLanes spheres_B{p_BC.x, p_BC.y, p_BC.z, node.r};
    Kernels::bounds(spheres_B, trees.probe(pair.body.bound_B), lower);
    trees.tool.for_children(
        pair.tool.part, lanes_below(lower, nearest.gap), [&](const TreePart& part, unsigned lanes) {
          const Sphere bound_B = bound_below(spheres_B, lanes, pair.tool.bound_B);
          found.insert({{part, bound_B}, pair.body}, smallest(lower, lanes));
        });
  } else {
    const SphereLanes spheres_B = lanes_of(trees.body.node(pair.body.part));
    Kernels::bounds(spheres_B, trees.probe(pair.tool.bound_B), lower);
    trees.body.for_children(
        pair.body.part, lanes_below(lower, nearest.gap), [&](const TreePart& part, unsigned lanes) {
          const Sphere bound_B = bound_below(spheres_B, lanes, pair.body.bound_B);
          found.insert({pair.tool, {part, bound_B}}, smallest(lower, lanes));
        });
  }
}

/// Lowers `nearest` to the gap of the tool to a body.
template <typename Kernels>
void nearest_on_body(const PlacedTrees& trees, NearestGap& nearest) noexcept {
  using Found = FarthestFirst<BodyPair>;
  DescentStack<Found::Entry, kBodyDescentSteps * kTreeWidth> stack;
  stack.push({trees.roots(), -std::numeric_limits<double>::infinity()});
  while (!stack.empty()) {
    const Found::Entry entry = stack.pop();
    if (!(entry.lower < nearest.gap)) continue;
    const Opening opening = choose_opening(entry.part);
    if (opening == Opening::kNeither) {
      nearest_of_surfaces<Kernels>(trees, entry.part, nearest);
      continue;
    }
    Found found;
    open_nearer<Kernels>(trees, entry.part, opening, nearest, found);
    nearest.tests += kTreeWidth;
    for (const auto& part : found) stack.push(part);
  }
}

}  // namespace hapticd
