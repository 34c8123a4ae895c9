// All contacts of the tool with one capsule below the margin: descends the tool's tree, the capsule
// taken into the tool's frame once. RT: yes; at most one step per node of the tool.
#pragma once

#include "core/collision/contact_collector.h"
#include "core/collision/descent.h"
#include "core/collision/node_kernels.h"

namespace hapticd {

/// Adds to `collector` the contacts of a segment of capsule number `obstacle`.
template <typename Kernels>
void collect_capsule(const LevelledTree& tool, const ToolPlacement& placement,
                     const AxisSegment& segment, std::int32_t obstacle,
                     ContactCollector& collector) noexcept {
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

}  // namespace hapticd
