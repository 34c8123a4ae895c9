// A hierarchical sphere-tree as the loop sees it: spans over memory owned by the scene. Wide nodes
// of up to eight children in structure-of-arrays form; every child bound contains all leaf spheres
// below it (conservative at every level). Frame: the tree's own (tool frame G or body frame B). RT:
// yes; 368 bytes per node, 32 bytes per leaf.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "core/geometry/sphere.h"

namespace hapticd {

/// Children per node.
inline constexpr int kTreeWidth = 8;
/// Levels below the root, at most (8^12 leaves); bounds every traversal stack.
inline constexpr int kMaxTreeDepth = 12;
/// `child` of an unused slot; its radius is -infinity, so that it is never nearer than anything.
inline constexpr std::int32_t kNoChild = std::numeric_limits<std::int32_t>::min();

/// Bounds and links of up to eight children. child >= 0: index of a node; child < 0 (but kNoChild):
/// leaf ~child, whose bound is the leaf sphere itself. Bit k of the masks speaks of slot k; at
/// least one slot is used.
struct alignas(64) SphereTreeNode {
  std::array<double, kTreeWidth> x, y, z, r;
  std::array<std::int32_t, kTreeWidth> child;
  std::uint32_t used;   ///< slots with a child
  std::uint32_t inner;  ///< slots whose child is a node
};

/// What bounds the leaf spheres below a node: far tighter than a sphere where they lie flat, as
/// those of a sounding board.
struct NodeBox {
  Vector3 lower;  ///< m
  Vector3 upper;  ///< m
};

/// How the leaves of a tree make one smooth surface (core/collision/blended_surface.h).
struct SurfaceBlend {
  double width = 0.0;         ///< m, >= 0; 0: they do not, and the surface is that of their union
  double least_radius = 0.0;  ///< of any leaf, m; 0 where width is
};

/// Node 0 is the root; nodes are in breadth-first order. `leaf_*` have equal size >= 1; radii
/// finite and >= 0.
struct SphereTreeView {
  std::span<const SphereTreeNode> nodes;
  std::span<const double> leaf_x, leaf_y, leaf_z, leaf_r;
  Sphere bound;   ///< contains every leaf
  int depth = 0;  ///< levels of nodes: 1 when the root's children are all leaves
  /// Largest distance by which the bound of a node sticks out of the bound of a node above it, m:
  /// bounds contain the leaves below them, not the bounds, so that they are as small as can be. A
  /// query that takes bounds for the surface allows for it.
  double overhang = 0.0;
  /// One per node; or none, then a query goes by the spheres alone: it finds the same and takes
  /// longer.
  std::span<const NodeBox> boxes{};
  SurfaceBlend blend{};

  /// Leaf sphere i, in the order the tree was built from.
  [[nodiscard]] Sphere leaf(std::int32_t i) const noexcept {
    const auto k = static_cast<std::size_t>(i);
    return {{leaf_x[k], leaf_y[k], leaf_z[k]}, leaf_r[k]};
  }
};

/// Names one sphere of a tree: leaf i (0 .. leaves-1), or, where a query stopped at a coarser
/// level, the bound in slot s of node n as -(8 n + s) - 1.
using TreeSphereId = std::int32_t;

/// Instead of a sphere: the blended surface of all leaves.
inline constexpr TreeSphereId kBlendedSurface = std::numeric_limits<TreeSphereId>::max();

[[nodiscard]] inline TreeSphereId bound_id(std::int32_t node, int slot) noexcept {
  return -(node * kTreeWidth + slot) - 1;
}

/// The sphere `id` of `tree`, in the tree's frame; not kBlendedSurface.
[[nodiscard]] Sphere tree_sphere(const SphereTreeView& tree, TreeSphereId id) noexcept;

/// Whether there is one of that id, or a surface of that name.
[[nodiscard]] inline bool has_sphere(const SphereTreeView& tree, TreeSphereId id) noexcept {
  if (id == kBlendedSurface) return tree.blend.width > 0.0;
  if (id >= 0) return static_cast<std::size_t>(id) < tree.leaf_x.size();
  return static_cast<std::size_t>(-(id + 1)) / kTreeWidth < tree.nodes.size();
}

/// Largest distance of any point of the tree's bound from the frame's origin, m: the lever that
/// turns |dtheta| into displacement.
[[nodiscard]] inline double reach(const SphereTreeView& tree) noexcept {
  return tree.bound.p.norm() + tree.bound.r;
}

}  // namespace hapticd
