// Reads one sphere of a sphere-tree by its id. See sphere_tree_view.h. RT: yes.
#include "core/geometry/sphere_tree_view.h"

namespace hapticd {

Sphere tree_sphere(const SphereTreeView& tree, TreeSphereId id) noexcept {
  if (id >= 0) return tree.leaf(id);
  const std::int32_t place = -(id + 1);
  const SphereTreeNode& node = tree.nodes[static_cast<std::size_t>(place / kTreeWidth)];
  const auto slot = static_cast<std::size_t>(place % kTreeWidth);
  return {{node.x[slot], node.y[slot], node.z[slot]}, node.r[slot]};
}

}  // namespace hapticd
