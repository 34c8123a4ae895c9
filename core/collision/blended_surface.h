// The smooth surface of a tree whose leaves are blended. With d_i the distances of a point from the
// leaf spheres and w the width of the blend, phi solves
//   sum_i K((d_i - phi) / w) = 1,   K(t) = (1 - t)^3 up to t = 1, then 0,
// and the surface is phi = 0. One leaf alone gives phi = d_i; more make phi smaller, by less than
// w:  min_i d_i - w < phi <= min_i d_i.  So what keeps phi >= 0 enters no leaf. phi is twice
// continuously differentiable; its gradient is a mean of the leaves' normals, hence never longer
// than 1, and phi never more than the distance from the surface. Frame: the tree's, B. RT: yes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/collision/primitive_gap.h"
#include "core/geometry/sphere_tree_view.h"
#include "core/math/realtime.h"

namespace hapticd {

/// A point beside a blended surface.
struct BlendedPlace {
  double distance = 0.0;             ///< phi, m
  Vector3 nhat_B = Vector3::Zero();  ///< direction of its gradient, unit; zero where there is none
  /// How the normal of the surface phi = const turns there, by place, 1/m: symmetric, and zero
  /// along the normal; positive where it bulges.
  Matrix3 curvature_B = Matrix3::Zero();
};

/// Leaves in one blend, at most; of more the nearest count, so that phi steps by what the farthest
/// add. A body has some seven.
inline constexpr std::size_t kMaxBlended = 64;

/// Leaves in ascending order, in arrays; the last twice where their number is odd.
template <std::size_t Capacity>
struct LeafLanes {
  static_assert(Capacity % 2 == 0);
  std::size_t count;
  alignas(16) std::array<double, Capacity> x, y, z, r;  ///< m
  std::array<TreeSphereId, Capacity> id;
};

/// The leaves around a point, to be used again next to it. What is found with it and without has
/// the same bits.
struct LeavesAround {
  static constexpr std::size_t kCapacity = 32;
  /// Whose they are, and of how many leaves; null: none.
  const SphereTreeNode* tree = nullptr;
  std::size_t size = 0;
  Vector3 p_B;
  double radius;  ///< how far from p_B they are all that matter, m
  LeafLanes<kCapacity> leaves;
  /// The last points beside that tree that were asked for, the newest first: a tick asks for the
  /// same several times, and for others in between.
  struct Found {
    Vector3 p_B;
    BlendedPlace place;
  };
  std::array<Found, 2> found;
};

/// The leaves around the spheres of a tool. Contents mean nothing but time; of one tool and the
/// bodies of one scene.
class BlendMemory {
 public:
  /// The place of a tool sphere.
  [[nodiscard]] LeavesAround& around(TreeSphereId tool_sphere) noexcept {
    return places_[static_cast<std::uint32_t>(tool_sphere) % kPlaces];
  }

 private:
  static constexpr std::uint32_t kPlaces = 128;
  std::array<LeavesAround, kPlaces> places_;
};

/// The point `p_B` beside the surface of `tree`, whose blend.width is above 0. About 0.2 us next to
/// where it was last asked with the same `memory`, 2 us elsewhere or without.
[[nodiscard]] HD_REALTIME BlendedPlace place_beside_blend(const SphereTreeView& tree,
                                                          const Vector3& p_B,
                                                          LeavesAround* memory = nullptr) noexcept;

/// What a leaf has in a blend: by how much phi sinks as its radius grows; all together 1.
struct BlendShare {
  TreeSphereId leaf;
  double share;
};

/// A point beside a blended surface, and whose it is.
struct BlendShares {
  double distance = 0.0;  ///< phi, m
  std::size_t count = 0;
  std::array<BlendShare, kMaxBlended> share;
};

/// The leaves that blend at `p_B`.
HD_REALTIME void find_shares(const SphereTreeView& tree, const Vector3& p_B,
                             BlendShares& out) noexcept;

/// The gap of a sphere with radius `r` (m) there; its offset is the normal.
[[nodiscard]] inline PrimitiveGap gap_to_blend(const BlendedPlace& place, double r) noexcept {
  return {place.nhat_B, length(place.nhat_B), place.distance - r, 0.0};
}

/// The sphere of 1 m radius whose distance at `p_B` is phi, with the same normal: for what knows
/// spheres alone.
[[nodiscard]] inline Sphere tangent_sphere(const BlendedPlace& place, const Vector3& p_B) noexcept {
  return {p_B - place.nhat_B, length(place.nhat_B) - place.distance};
}

/// What a place counts for in the work of a tick, whether or not it is remembered: it must not
/// depend on what was asked before.
inline constexpr int kBlendTests = 64;

/// How far the surface of `tree` may stick out of its spheres, m.
[[nodiscard]] inline double blend_reach(const SphereTreeView& tree) noexcept {
  return tree.blend.width;
}

/// Whether a query that stops at `last_level` meets the blended surface. A coarser one takes bounds
/// for the surface, and these that much larger.
[[nodiscard]] inline bool meets_blend(const SphereTreeView& tree, int last_level) noexcept {
  return tree.blend.width > 0.0 && last_level >= tree.depth;
}

}  // namespace hapticd
