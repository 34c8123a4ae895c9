// Going down a sphere-tree: the node at hand, the level at which a query stops, a stack of fixed
// size. RT: yes.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <new>
#include <type_traits>

#include "core/geometry/sphere_tree_view.h"
#include "core/math/assert.h"

namespace hapticd {

/// A node of a tree and the level of its bound; the whole tree's is 0.
struct TreePart {
  std::int32_t node;
  std::int32_t level;
};

/// A tree and the level (>= 1) at which a query takes bounds for the surface.
struct LevelledTree {
  SphereTreeView tree;
  int last_level;

  /// The whole tree.
  [[nodiscard]] static TreePart root() noexcept { return {0, 0}; }
  [[nodiscard]] const SphereTreeNode& node(const TreePart& part) const noexcept {
    return tree.nodes[static_cast<std::size_t>(part.node)];
  }
  /// Children of the node that have to be opened.
  [[nodiscard]] unsigned inner(const TreePart& part) const noexcept {
    return part.level + 1 >= last_level ? 0U : node(part).inner;
  }
  /// Children of the node that are the surface.
  [[nodiscard]] unsigned surface(const TreePart& part) const noexcept {
    return node(part).used & ~inner(part);
  }
  /// The part below child `k`, which is inner.
  [[nodiscard]] TreePart child(const TreePart& part, int k) const noexcept {
    return {node(part).child[static_cast<std::size_t>(k)], part.level + 1};
  }
  /// The boxes of the nodes, null where they do not bound the surface: that of a coarser level
  /// sticks out of them.
  [[nodiscard]] const NodeBox* boxes() const noexcept {
    return last_level < tree.depth || tree.boxes.empty() ? nullptr : tree.boxes.data();
  }
  /// Name of surface child `k` in contacts.
  [[nodiscard]] TreeSphereId id(const TreePart& part, int k) const noexcept {
    const std::int32_t below = node(part).child[static_cast<std::size_t>(k)];
    return below < 0 ? ~below : bound_id(part.node, k);
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
