// The descent of a tool's tree and a body's tree together, common to the search for contacts and
// the search for the smallest gap. Everything is in the body's frame B: the body's bounds as they
// are stored, the tool's taken there when their node is opened. RT: yes.
#pragma once

#include "core/collision/descent.h"
#include "core/collision/node_kernels.h"

namespace hapticd {

/// Parts whose surface spheres are at hand are opened further, into single spheres, only against
/// parts this much smaller. Normal value 2. Costs only time: near 1 leaves the eight-wide loops too
/// early, far above tries distant spheres of coarse tools.
inline constexpr double kSplitRatio = 2.0;
/// Steps of one descent: every level of both trees, and a split of the surface at the end of each.
inline constexpr int kBodyDescentSteps = 2 * (kMaxTreeDepth + 1);

/// A part of either tree and a sphere in B that contains it.
struct PlacedPart {
  TreePart part;
  Sphere bound_B;
};

/// Both parts of a step.
struct BodyPair {
  PlacedPart tool;
  PlacedPart body;
};

/// A tool and a body, placed.
struct PlacedTrees {
  LevelledTree tool;
  LevelledTree body;
  PlacedBody placement;
  double slack;  ///< of every bound, m

  [[nodiscard]] BodyPair roots() const noexcept {
    const Sphere& bound_G = tool.tree.bound;
    return {{tool.root(), {to_body(placement, bound_G.p), bound_G.r}},
            {body.root(), body.tree.bound}};
  }
  /// `sphere_B` as a probe of either tree.
  [[nodiscard]] SphereProbe probe(const Sphere& sphere_B) const noexcept {
    return {sphere_B.p, sphere_B.r + slack};
  }
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

/// Bound of what lies below the children `lanes` of a node: the child's own where it is one, else
/// that of the whole node.
[[nodiscard]] inline Sphere bound_below(const SphereLanes& spheres_B, unsigned lanes,
                                        const Sphere& whole_B) noexcept {
  if (!std::has_single_bit(lanes)) return whole_B;
  const auto k = static_cast<std::size_t>(std::countr_zero(lanes));
  return {{spheres_B.x[k], spheres_B.y[k], spheres_B.z[k]}, spheres_B.r[k]};
}

enum class Opening : std::uint8_t { kTool, kBody, kNeither };

/// Which part to open: the larger, while it is unopened or much larger; neither when both are
/// surfaces of like size, which are compared as they are.
[[nodiscard]] inline Opening choose_opening(const BodyPair& pair) noexcept {
  const unsigned tool = pair.tool.part.surface;
  const unsigned body = pair.body.part.surface;
  const double r_tool = pair.tool.bound_B.r;
  const double r_body = pair.body.bound_B.r;
  const bool tool_opens =
      tool == 0 || (!std::has_single_bit(tool) && r_tool > kSplitRatio * r_body);
  const bool body_opens =
      body == 0 || (!std::has_single_bit(body) && r_body > kSplitRatio * r_tool);
  if (tool_opens && body_opens) return r_tool > r_body ? Opening::kTool : Opening::kBody;
  if (tool_opens) return Opening::kTool;
  return body_opens ? Opening::kBody : Opening::kNeither;
}

}  // namespace hapticd
