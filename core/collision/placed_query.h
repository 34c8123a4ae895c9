// A query on its way through the obstacles, and the two sides of a pair: what all primitives work
// on. Internal to the folder. RT: yes.
#pragma once

#include "core/collision/body_descent.h"
#include "core/collision/contact_collector.h"
#include "core/collision/query.h"

namespace hapticd {

/// One query: tool, obstacles, and how far down their trees it goes.
struct PlacedQuery {
  LevelledTree tool;
  ToolPlacement placement;
  const ObstaclesView& obstacles;
  const QueryOptions& options;
};

[[nodiscard]] inline LevelledTree levelled(const SphereTreeView& tree, int level) noexcept {
  HD_ASSERT(tree.depth <= kMaxTreeDepth);
  return {tree, level};
}

/// The smallest gap over all obstacles, as far as it has been searched.
struct NearestGap {
  double gap;              ///< smallest found so far, or the horizon, m
  std::int64_t tests = 0;  ///< bounds and spheres evaluated
};

/// Between what pairs are evaluated.
struct PairSides {
  const ToolView& tool;
  const ObstaclesView& obstacles;

  [[nodiscard]] Sphere tool_sphere(const ContactKey& key) const noexcept {
    const DisplacedParts& displaced = tool.displaced;
    Sphere sphere_G = tree_sphere(tool.tree, key.tool_sphere);
    if (displaced.parts.empty()) return sphere_G;
    const int k = displaced.find(key.tool_sphere);
    if (k >= 0) sphere_G.p += displaced.parts[static_cast<std::size_t>(k)].v_G;
    return sphere_G;
  }
};

}  // namespace hapticd
