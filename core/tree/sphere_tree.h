// Owner of a sphere-tree and its builder from leaf spheres: every bound contains all leaf spheres
// below it, to rounding upwards. Offline (allocates); never called from the loop.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/sphere_tree_view.h"

namespace hapticd {

/// Memory behind a SphereTreeView. Leaves keep the order they were given in (so ids mean what the
/// caller knows).
struct SphereTree {
  std::vector<SphereTreeNode> nodes;
  std::vector<double> leaf_x, leaf_y, leaf_z, leaf_r;
  Sphere bound;
  int depth = 0;
  double overhang = 0.0;
  std::vector<NodeBox> boxes;  ///< one per node
  SurfaceBlend blend;

  /// View of this tree; valid while the tree lives and is not modified.
  [[nodiscard]] SphereTreeView view() const noexcept;
};

/// Builds a tree over `leaves` (>= 1, finite centres, finite radii >= 0). Deterministic; O(n log
/// n). Throws std::invalid_argument naming the offending leaf.
[[nodiscard]] SphereTree build_sphere_tree(std::span<const Sphere> leaves);

/// Makes the leaves of `tree` one smooth surface; `width` (m) finite, >= 0. O(leaves).
void blend_surface(double width, SphereTree& tree);

/// Spheres of every level of `tree`, from the root's children to the leaves: TreeLevel::spheres.
[[nodiscard]] std::vector<std::int32_t> spheres_per_level(const SphereTree& tree);

/// What SphereTreeView::overhang of `tree` has to be, m. Nodes in breadth-first order; O(nodes
/// depth).
[[nodiscard]] double largest_overhang(const SphereTree& tree);

/// What SphereTreeView::boxes of `tree` have to be. Nodes in breadth-first order; O(nodes).
[[nodiscard]] std::vector<NodeBox> bounding_boxes(const SphereTree& tree);

}  // namespace hapticd
