// The descent of a tool's tree and a body's tree together, common to the search for contacts and
// the search for the smallest gap: eight spheres of the one against eight of the other, at every
// level. Everything is in the body's frame B: the body's spheres as they are stored, the tool's
// taken there node by node. RT: yes.
#pragma once

#include "core/collision/descent.h"
#include "core/collision/node_kernels.h"

namespace hapticd {

/// Of two nodes a body's is opened alone where its children are this much larger than the tool's.
/// Normal value 8. Costs only time: less opens bodies where their boxes say as much, more compares
/// many small spheres of the tool with a large one.
inline constexpr double kBodyFirst = 8.0;
/// A tool's node is opened alone where its children are larger than this share of the body's, else
/// both. Normal value 0.25: boxes leave little room around what is flat, so that small spheres of
/// the tool against large parts of the body soon tell. Costs only time.
inline constexpr double kToolFirst = 0.25;

/// A tool and a body, placed.
struct PlacedTrees {
  LevelledTree tool;
  LevelledTree body;
  PlacedBody placement;
  double slack;  ///< of every comparison, m
};

[[nodiscard]] inline PlacedTrees place_trees(const LevelledTree& tool,
                                             const ToolPlacement& placement,
                                             const LevelledTree& body, const Pose& X_WB) noexcept {
  const PlacedBody placed = place_body(X_WB, placement);
  const double extent = length(placed.p_BG) + reach(tool.tree) + reach(body.tree);
  const double overhang =
      surface_overhang(tool.tree, tool.last_level) + surface_overhang(body.tree, body.last_level);
  return {tool, body, placed, kRelativeSlack * extent + overhang};
}

/// Some children of a node.
struct Children {
  TreePart part;
  unsigned lanes;
};

/// Two nodes whose children are to be compared.
struct NodePair {
  Children tool;
  Children body;
};

/// Calls visitor.hit(pair, i, k, p_BC) for all surface children i of a tool's node and k of a
/// body's node that may have a gap below visitor.radius(), which may shrink on the way; p_BC are
/// the centres of the tool's children. A visitor that wants each sphere of the tool once
/// (kOnce) says with done(part) which children of the tool's node it has had, a bit each.
template <typename Kernels, typename Visitor>
class BodyDescent {
 public:
  BodyDescent(const PlacedTrees& trees, Visitor& visitor) noexcept
      : boxes_(trees.body.boxes()), trees_(trees), visitor_(visitor) {}

  void run() noexcept {
    const TreePart root = LevelledTree::root();
    stack_.push({{root, trees_.tool.node(root).used}, {root, trees_.body.node(root).used}});
    while (!stack_.empty()) compare(stack_.pop());
  }

 private:
  /// Every step goes down one level at least, and leaves at most 64 pairs behind.
  static constexpr int kCapacity = 2 * kMaxTreeDepth * (kTreeWidth * kTreeWidth - 1) + 1;

  void compare(const NodePair& all) noexcept {
    if constexpr (Visitor::kOnce) {
      NodePair rest = all;
      rest.tool.lanes &= ~visitor_.done(all.tool.part);
      if (rest.tool.lanes != 0) compare_rest(rest);
    } else {
      compare_rest(all);
    }
  }

  void compare_rest(const NodePair& pair) noexcept {
    const SphereTreeNode& tool = trees_.tool.node(pair.tool.part);
    const SphereTreeNode& body = trees_.body.node(pair.body.part);
    if (placed_ != &tool) {
      Kernels::to_body(tool, trees_.placement, p_BC_);
      placed_ = &tool;
    }
    if (boxes_ != nullptr && near_box(tool, pair.body.part) == 0) return;
    PairMask near =
        Kernels::near_pairs({p_BC_.x, p_BC_.y, p_BC_.z, tool.r}, pair.tool.lanes, lanes_of(body),
                            pair.body.lanes, visitor_.radius() + trees_.slack);
    visitor_.count_tests(kTreeWidth * std::popcount(pair.body.lanes));
    if (near == 0) return;
    unsigned tool_opens = trees_.tool.inner(pair.tool.part) & pair.tool.lanes;
    unsigned body_opens = trees_.body.inner(pair.body.part) & pair.body.lanes;
    if ((tool_opens | body_opens) == 0) {
      hit(pair, near, 0);
      return;
    }
    const double r_tool = tool.r[first_lane(pair.tool.lanes)];
    const double r_body = body.r[first_lane(pair.body.lanes)];
    // What waits for the other to be opened must not meet a surface sphere there.
    if (r_body > kBodyFirst * r_tool && body_opens == pair.body.lanes) {
      tool_opens = 0;
    } else if (r_tool > kToolFirst * r_body && tool_opens == pair.tool.lanes) {
      body_opens = 0;
    }
    if (boxes_ != nullptr) near = near_boxes(pair, near, body_opens);
    open(pair, near, tool_opens, body_opens);
  }

  /// Children of a tool's node, whose centres are p_BC_, that may be near to what is below a
  /// body's.
  unsigned near_box(const SphereTreeNode& tool, const TreePart& body) noexcept {
    visitor_.count_tests(kTreeWidth);
    return Kernels::near_box(p_BC_, tool.r, boxes_[body.node], visitor_.radius() + trees_.slack);
  }

  /// What is left of `near` where the boxes of the children `body_opens` are looked at too.
  PairMask near_boxes(const NodePair& pair, PairMask near, unsigned body_opens) noexcept {
    const SphereTreeNode& tool = trees_.tool.node(pair.tool.part);
    for (; body_opens != 0; body_opens &= body_opens - 1) {
      const int k = std::countr_zero(body_opens);
      if (tool_lanes(near, k) == 0) continue;
      const unsigned far = ~near_box(tool, trees_.body.child(pair.body.part, k)) & 0xFFU;
      near &= ~(PairMask{far} << (kTreeWidth * k));
    }
    return near;
  }

  /// Goes below the children `tool_opens` and `body_opens` of the pair, where they are near.
  void open(const NodePair& pair, PairMask near, unsigned tool_opens,
            unsigned body_opens) noexcept {
    for (unsigned rest = tool_opens & tool_lanes(near); rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest);
      const unsigned lanes = body_lanes(near, i);
      const TreePart tool = trees_.tool.child(pair.tool.part, i);
      if (const unsigned kept = lanes & ~body_opens; kept != 0) push(tool, {pair.body.part, kept});
      for (unsigned opened = lanes & body_opens; opened != 0; opened &= opened - 1) {
        push_both(pair, i, tool, std::countr_zero(opened));
      }
    }
    for (unsigned rest = pair.body.lanes; rest != 0; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const unsigned lanes = tool_lanes(near, k) & ~tool_opens;
      if (lanes == 0) continue;
      if ((body_opens >> k & 1U) == 0) {
        hit(pair, lanes, k);
      } else {
        const TreePart body = trees_.body.child(pair.body.part, k);
        stack_.push({{pair.tool.part, lanes}, {body, trees_.body.node(body).used}});
      }
    }
  }

  void push(const TreePart& tool, const Children& body) noexcept {
    stack_.push({{tool, trees_.tool.node(tool).used}, body});
  }

  /// What is below the tool's child i, which is `tool`, against those spheres below the body's
  /// child k that are near to it: mostly few, often none.
  void push_both(const NodePair& pair, int i, const TreePart& tool, int k) noexcept {
    const auto row = static_cast<std::size_t>(i);
    const SphereProbe probe{p_BC_[row], trees_.tool.node(pair.tool.part).r[row] + trees_.slack};
    const TreePart body = trees_.body.child(pair.body.part, k);
    const unsigned lanes =
        Kernels::near(lanes_of(trees_.body.node(body)), probe, visitor_.radius());
    visitor_.count_tests(kTreeWidth);
    if (lanes != 0) push(tool, {body, lanes});
  }

  void hit(const NodePair& pair, PairMask near, int first_row) noexcept {
    for (; near != 0; near &= near - 1) {
      const int bit = std::countr_zero(near);
      visitor_.hit(pair, bit % kTreeWidth, first_row + bit / kTreeWidth, p_BC_);
    }
  }

  static std::size_t first_lane(unsigned lanes) noexcept {
    return static_cast<std::size_t>(std::countr_zero(lanes));
  }

  PointLanes p_BC_;  ///< centres of `placed_`
  const SphereTreeNode* placed_ = nullptr;
  const NodeBox* boxes_;  ///< of the body's nodes; null: none
  const PlacedTrees& trees_;
  Visitor& visitor_;
  DescentStack<NodePair, kCapacity> stack_;
};

}  // namespace hapticd
