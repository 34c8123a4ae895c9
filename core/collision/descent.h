// Going down a sphere-tree: what is at hand (an unopened bound, or surface spheres of one node),
// the level at which a query stops, a stack of fixed size. RT: yes.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <new>
#include <type_traits>

#include "core/geometry/sphere_tree_view.h"
#include "core/math/assert.h"

namespace hapticd {

/// Part of a tree: the bound over `node`; when `surface` is not 0, the children of `node` in that
/// mask, taken for the surface itself.
struct TreePart {
  std::int32_t node;
  std::int32_t level;     ///< of the bound; the whole tree's is 0
  std::uint32_t surface;  ///< 0: unopened
};

/// A tree and the level (>= 1) at which a query takes bounds for the surface.
struct LevelledTree {
  SphereTreeView tree;
  int last_level;

  [[nodiscard]] const SphereTreeNode& node(const TreePart& part) const noexcept {
    return tree.nodes[static_cast<std::size_t>(part.node)];
  }
  /// Children of part.node that have to be opened.
  [[nodiscard]] unsigned inner(const TreePart& part) const noexcept {
    return part.level + 1 >= last_level ? 0U : node(part).inner;
  }
  /// Children of part.node that are the surface.
  [[nodiscard]] unsigned surface(const TreePart& part) const noexcept {
    return node(part).used & ~inner(part);
  }
  /// The whole tree.
  [[nodiscard]] TreePart root() const noexcept { return settled({0, 0, 0}); }
  /// The part below child `k`, which is inner.
  [[nodiscard]] TreePart child(const TreePart& part, int k) const noexcept {
    return settled({node(part).child[static_cast<std::size_t>(k)], part.level + 1, 0});
  }
  /// Surface children `mask` of `part` as a part of their own.
  [[nodiscard]] static TreePart surface_of(const TreePart& part, unsigned mask) noexcept {
    return {part.node, part.level, mask};
  }
  /// Name of surface child `k` in contacts.
  [[nodiscard]] TreeSphereId id(const TreePart& part, int k) const noexcept {
    const std::int32_t below = node(part).child[static_cast<std::size_t>(k)];
    return below < 0 ? ~below : bound_id(part.node, k);
  }

  /// Calls visit(part, lanes) for what lies below those children of `part` that are in `mask`:
  /// inner ones one by one, surface ones of an unopened part together, of a surface part one by
  /// one.
  template <typename Visit>
  void for_children(const TreePart& part, unsigned mask, const Visit& visit) const noexcept {
    const unsigned inner_mask = part.surface != 0 ? 0U : inner(part);
    for (unsigned rest = mask & inner_mask; rest != 0; rest &= rest - 1) {
      visit(child(part, std::countr_zero(rest)), rest & -rest);
    }
    unsigned rest = mask & ~inner_mask & (part.surface != 0 ? part.surface : node(part).used);
    if (rest != 0 && part.surface == 0) {
      visit(surface_of(part, rest), rest);
      return;
    }
    for (; rest != 0; rest &= rest - 1) visit(surface_of(part, rest & -rest), rest & -rest);
  }

 private:
  /// A bound with nothing but surface below needs no opening.
  [[nodiscard]] TreePart settled(TreePart part) const noexcept {
    if (inner(part) == 0) part.surface = node(part).used;
    return part;
  }
};

/// Stack of at most `Capacity` items; only those in use are ever constructed.
template <typename T, int Capacity>
class DescentStack {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  DescentStack() noexcept {}
  void push(const T& item) noexcept {
    HD_ASSERT(size_ < kCapacity);
    ::new (static_cast<void*>(&items_[size_++])) T(item);
  }
  [[nodiscard]] T pop() noexcept { return items_[--size_]; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }

 private:
  static constexpr std::size_t kCapacity = Capacity;
  std::size_t size_ = 0;
  union {
    std::array<T, kCapacity> items_;
  };
};

}  // namespace hapticd
