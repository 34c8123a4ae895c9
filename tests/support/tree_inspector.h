// Looks at every node of a sphere-tree and notes everything that is wrong with it. Independent of
// the builder and the reader: long double, the leaf spheres themselves.
#pragma once

#include <vector>

#include "core/geometry/sphere_tree_view.h"

namespace hapticd::test {

class TreeInspector {
 public:
  /// `spheres`: the leaves as they should be. O(leaves depth).
  TreeInspector(const SphereTreeView& tree, const std::vector<Sphere>& spheres);

  /// Distance by which a leaf sphere sticks out of a bound above it, at worst, m; <= 0: none does.
  [[nodiscard]] long double worst_leaf() const { return worst_; }
  /// Every leaf and every node is reached exactly once.
  [[nodiscard]] bool complete() const;
  /// Masks, unused slots and the order of nodes are as the view's header says.
  [[nodiscard]] bool well_formed() const { return well_formed_; }
  /// Levels of nodes.
  [[nodiscard]] int deepest() const;
  /// All of it: well formed, complete, conservative, as deep as it says and not too deep.
  [[nodiscard]] bool sound() const;

 private:
  void expect(bool condition) { well_formed_ = well_formed_ && condition; }
  void check_links(std::size_t n);
  void check_bounds(std::size_t n);
  [[nodiscard]] Sphere bound(std::size_t n, std::size_t k) const;
  void note(const Sphere& bound, const std::vector<std::int32_t>& leaves);

  const SphereTreeView& tree_;
  const std::vector<Sphere>& spheres_;
  std::vector<int> leaf_seen_, node_seen_, level_;
  std::vector<std::vector<std::int32_t>> leaves_below_;
  long double worst_;
  bool well_formed_ = true;
};

/// The leaves of `tree`, in their order.
[[nodiscard]] std::vector<Sphere> leaves_of(const SphereTreeView& tree);

}  // namespace hapticd::test
