// The primitive of strings and rigid lines: capsules, straight or bent in two legs. All contacts of
// the tool with one below the margin, and the smallest gap: descends the tool's tree, the capsule
// taken into the tool's frame once. RT: yes; at most one step per node of the tool.
#pragma once

#include "core/collision/descent.h"
#include "core/collision/node_kernels.h"
#include "core/collision/pair_batch.h"
#include "core/collision/placed_query.h"

namespace hapticd {

/// Where anything must be that is nearer to the tool than `gap`: around its origin, with room for
/// rounding.
inline Neighbourhood neighbourhood(const PlacedQuery& query, double gap) noexcept {
  const double radius =
      gap + reach(query.tool.tree) + surface_overhang(query.tool.tree, query.tool.last_level);
  return {query.placement.p_WG, radius + kRelativeSlack * (radius + length(query.placement.p_WG))};
}

/// Adds to `collector` the contacts of a segment of capsule number `obstacle`.
template <typename Kernels>
void collect_capsule(const PlacedQuery& query, const AxisSegment& segment, std::int32_t obstacle,
                     ContactCollector& collector) noexcept {
  const LevelledTree& tool = query.tool;
  const ToolPlacement& placement = query.placement;
  const Capsule& capsule_W = segment.capsule_W;
  const PlacedCapsule capsule = place_capsule(capsule_W, placement.p_WG);
  const CapsuleProbe probe = probe_capsule(capsule, placement.R_WG, reach(tool.tree),
                                           surface_overhang(tool.tree, tool.last_level));
  const Vector3 axis_W = capsule_W.p_B - capsule_W.p_A;
  CapsuleGaps gaps;
  DescentStack<TreePart, kMaxTreeDepth*(kTreeWidth - 1) + 1> stack;
  stack.push(LevelledTree::root());
  while (!stack.empty()) {
    const TreePart part = stack.pop();
    const SphereTreeNode& node = tool.node(part);
    const unsigned surface = tool.surface(part);
    if (const unsigned inner = tool.inner(part); inner != 0) {
      unsigned near = Kernels::near(lanes_of(node), probe, collector.margin()) & inner;
      for (; near != 0; near &= near - 1) stack.push(tool.child(part, std::countr_zero(near)));
      collector.count_tests(kTreeWidth);
    }
    if (surface == 0) continue;
    unsigned hit =
        Kernels::capsule_gaps(node, surface, placement.R_WG, capsule, collector.margin(), gaps);
    collector.count_tests(kTreeWidth);
    for (; hit != 0; hit &= hit - 1) {
      const int lane = std::countr_zero(hit);
      const auto k = static_cast<std::size_t>(lane);
      const PrimitiveGap pair = gaps.lanes.pair(k, string_lambda(segment, gaps.lambda[k]));
      const TreeSphereId tool_sphere = tool.id(part, lane);
      if (!collector.wants(tool_sphere, pair.gap)) continue;
      collector.add(pair.gap, [&](Contact& contact) {
        contact =
            make_contact({ObstacleKind::kCapsule, obstacle, tool_sphere, segment.leg}, pair,
                         capsule_normal(pair, axis_W), {gaps.p_GC_W[k], node.r[k], placement.p_WG});
      });
    }
  }
}

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
void nearest_on_capsule(const PlacedQuery& query, const Capsule& capsule_W,
                        NearestGap& nearest) noexcept {
  const LevelledTree& tool = query.tool;
  const ToolPlacement& placement = query.placement;
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

/// See primitives.h.
struct CapsuleGap {
  static bool same_obstacle(const ContactKey& key, const ContactKey& other) noexcept {
    return key.obstacle == other.obstacle && key.obstacle_sphere == other.obstacle_sphere;
  }

  static bool has(const ObstaclesView& obstacles, const ContactKey& key) noexcept {
    return static_cast<std::size_t>(key.obstacle) < obstacles.capsules_W.size() &&
           (key.obstacle_sphere == 0 || key.obstacle_sphere == 1);
  }

  /// About its axis along the straight part alone.
  static RoundObstacle round(const PairSides& sides, const Contact& contact) noexcept {
    const ContactKey& key = contact.key;
    const Capsule capsule =
        segment_of(sides.obstacles, key.obstacle, key.obstacle_sphere).capsule_W;
    if (!(contact.lambda > 0.0 && contact.lambda < 1.0)) return {capsule.r, Vector3::Zero()};
    return {capsule.r, (capsule.p_B - capsule.p_A).normalized()};
  }

  static Contact evaluate(const PairSides& sides, const ContactKey& key) noexcept {
    const ToolPlacement placement = place_tool(sides.tool.X_WG);
    const Sphere sphere_G = sides.tool_sphere(key);
    const PlacedSphere placed{rotate(placement.R_WG, sphere_G.p), sphere_G.r, placement.p_WG};
    const AxisSegment segment = segment_of(sides.obstacles, key.obstacle, key.obstacle_sphere);
    const Capsule& capsule = segment.capsule_W;
    PrimitiveGap pair =
        gap_to_capsule(placed.p_GC_W, placed.r, place_capsule(capsule, placement.p_WG));
    pair.lambda = string_lambda(segment, pair.lambda);
    return make_contact(key, pair, capsule_normal(pair, capsule.p_B - capsule.p_A), placed);
  }

  static void begin(const PairSides& sides, const ContactKey& key, PairBatch& batch) noexcept {
    batch.begin(segment_of(sides.obstacles, key.obstacle, key.obstacle_sphere));
  }
  static void add(const PairSides& sides, const ContactKey& key, PairBatch& batch) noexcept {
    batch.add(sides.tool_sphere(key));
  }

  template <typename Kernels>
  [[gnu::always_inline]] static void collect(const PlacedQuery& query,
                                             ContactCollector& collector) noexcept {
    for_each_segment(query.obstacles, neighbourhood(query, query.options.margin),
                     [&](std::int32_t capsule, const AxisSegment& segment) {
                       collect_capsule<Kernels>(query, segment, capsule, collector);
                     });
  }

  template <typename Kernels>
  [[gnu::always_inline]] static void find_nearest(const PlacedQuery& query,
                                                  NearestGap& nearest) noexcept {
    for_each_segment(query.obstacles, neighbourhood(query, nearest.gap),
                     [&](std::int32_t, const AxisSegment& segment) {
                       nearest_on_capsule<Kernels>(query, segment.capsule_W, nearest);
                     });
  }
};

}  // namespace hapticd
