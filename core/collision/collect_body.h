// All contacts of the tool with one body below the margin: descends both trees until eight spheres
// of the one stand against eight of the other. RT: yes.
#pragma once

#include "core/collision/body_descent.h"
#include "core/collision/contact_collector.h"

namespace hapticd {

template <typename Kernels>
class BodyCollection {
 public:
  BodyCollection(const PlacedTrees& trees, const ToolPlacement& tool_placement,
                 std::int32_t obstacle, ContactCollector& collector) noexcept
      : trees_(trees),
        tool_placement_(tool_placement),
        obstacle_(obstacle),
        collector_(collector) {}

  /// Adds the contacts of the body to the collector.
  void run() noexcept {
    take(trees_.roots());
    while (!stack_.empty()) {
      const BodyPair pair = stack_.pop();
      if (choose_opening(pair) == Opening::kTool) {
        open_tool(pair);
      } else {
        open_body(pair);
      }
    }
  }

 private:
  void take(const BodyPair& pair) noexcept {
    if (choose_opening(pair) == Opening::kNeither) {
      compare(pair);
    } else {
      stack_.push(pair);
    }
  }

  void open_tool(const BodyPair& pair) noexcept {
    const SphereTreeNode& node = trees_.tool.node(pair.tool.part);
    PointLanes p_BC;
    Kernels::to_body(node, trees_.placement, p_BC);
    const SphereLanes spheres_B{p_BC.x, p_BC.y, p_BC.z, node.r};
    const unsigned near = near_lanes(spheres_B, pair.body.bound_B);
    trees_.tool.for_children(pair.tool.part, near, [&](const TreePart& part, unsigned lanes) {
      take({{part, bound_below(spheres_B, lanes, pair.tool.bound_B)}, pair.body});
    });
  }

  void open_body(const BodyPair& pair) noexcept {
    const SphereLanes spheres_B = lanes_of(trees_.body.node(pair.body.part));
    const unsigned near = near_lanes(spheres_B, pair.tool.bound_B);
    trees_.body.for_children(pair.body.part, near, [&](const TreePart& part, unsigned lanes) {
      take({pair.tool, {part, bound_below(spheres_B, lanes, pair.body.bound_B)}});
    });
  }

  unsigned near_lanes(const SphereLanes& spheres_B, const Sphere& other_B) noexcept {
    collector_.count_tests(kTreeWidth);
    return Kernels::near(spheres_B, trees_.probe(other_B), collector_.margin());
  }

  /// Adds the contacts of two surfaces.
  void compare(const BodyPair& pair) noexcept {
    const SphereTreeNode& tool = trees_.tool.node(pair.tool.part);
    const SphereTreeNode& body = trees_.body.node(pair.body.part);
    const unsigned body_lanes =
        near_lanes(lanes_of(body), pair.tool.bound_B) & pair.body.part.surface;
    if (body_lanes == 0) return;
    if (compared_ != &tool) {
      Kernels::to_body(tool, trees_.placement, p_BC_);
      compared_ = &tool;
    }
    const SphereLanes tool_B{p_BC_.x, p_BC_.y, p_BC_.z, tool.r};
    const unsigned tool_lanes = near_lanes(tool_B, pair.body.bound_B) & pair.tool.part.surface;
    if (tool_lanes == 0) return;
    unsigned any = Kernels::pair_gaps(tool_B, tool_lanes, lanes_of(body), body_lanes,
                                      collector_.margin(), trees_.slack, gaps_);
    collector_.count_tests(std::popcount(tool_lanes) * kTreeWidth);
    for (; any != 0; any &= any - 1) add_contacts(pair, std::countr_zero(any));
  }

  /// Adds the contacts of the tool's child `i`.
  void add_contacts(const BodyPair& pair, int i) noexcept {
    const auto row = static_cast<std::size_t>(i);
    const SphereTreeNode& tool = trees_.tool.node(pair.tool.part);
    const PlacedSphere sphere{rotate(tool_placement_.R_WG, {tool.x[row], tool.y[row], tool.z[row]}),
                              tool.r[row], tool_placement_.p_WG};
    const TreeSphereId tool_id = trees_.tool.id(pair.tool.part, i);
    for (unsigned hit = gaps_.hit[row]; hit != 0; hit &= hit - 1) {
      const int k = std::countr_zero(hit);
      const PrimitiveGap gap = gaps_.lanes[row].pair(static_cast<std::size_t>(k), 0.0);
      if (!collector_.wants(gap.gap)) continue;
      collector_.add(
          make_contact({ObstacleKind::kBody, obstacle_, tool_id, trees_.body.id(pair.body.part, k)},
                       gap, body_normal(gap, trees_.placement.R_WB), sphere));
    }
  }

  const PlacedTrees& trees_;
  const ToolPlacement& tool_placement_;
  const std::int32_t obstacle_;
  ContactCollector& collector_;
  DescentStack<BodyPair, kBodyDescentSteps*(kTreeWidth - 1) + 1> stack_;
  PairGaps gaps_;
  PointLanes p_BC_;  ///< centres of `compared_`
  const SphereTreeNode* compared_ = nullptr;
};

}  // namespace hapticd
