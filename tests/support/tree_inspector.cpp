// See tree_inspector.h.
#include "tests/support/tree_inspector.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool is_leaf(const Sphere& a, const Sphere& b) { return a.p == b.p && a.r == b.r; }

}  // namespace

TreeInspector::TreeInspector(const SphereTreeView& tree, const std::vector<Sphere>& spheres)
    : tree_(tree),
      spheres_(spheres),
      leaf_seen_(spheres.size()),
      node_seen_(tree.nodes.size()),
      level_(tree.nodes.size(), 1),
      leaves_below_(tree.nodes.size()),
      worst_(-std::numeric_limits<long double>::infinity()) {
  node_seen_[0] = 1;
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) check_links(n);
  // Children come after their parents, so backwards the leaves of a child are known.
  if (well_formed_) {
    for (std::size_t n = tree.nodes.size(); n-- > 0;) check_bounds(n);
    note(tree.bound, leaves_below_[0]);
  }
}

bool TreeInspector::complete() const {
  const auto once = [](int n) { return n == 1; };
  return std::all_of(leaf_seen_.begin(), leaf_seen_.end(), once) &&
         std::all_of(node_seen_.begin(), node_seen_.end(), once);
}

int TreeInspector::deepest() const { return *std::max_element(level_.begin(), level_.end()); }

bool TreeInspector::sound() const {
  return well_formed_ && complete() && worst_ <= 0.0L && deepest() == tree_.depth &&
         tree_.depth <= kMaxTreeDepth;
}

void TreeInspector::check_links(std::size_t n) {
  const SphereTreeNode& node = tree_.nodes[n];
  expect(node.used != 0 && (node.inner & ~node.used) == 0);
  for (std::size_t k = 0; k < kTreeWidth; ++k) {
    const std::int32_t child = node.child[k];
    if ((node.used >> k & 1U) == 0) {
      expect(child == kNoChild && node.r[k] == -kInfinity);
      continue;
    }
    expect(((node.inner >> k & 1U) != 0) == (child >= 0));
    const auto index = static_cast<std::size_t>(child >= 0 ? child : -1 - child);
    if (child < 0) {
      expect(index < leaf_seen_.size() && is_leaf(bound(n, k), spheres_[index]));
      if (well_formed_) ++leaf_seen_[index];
    } else {
      expect(index > n && index < node_seen_.size());
      if (!well_formed_) return;
      ++node_seen_[index];
      level_[index] = level_[n] + 1;
    }
  }
}

void TreeInspector::check_bounds(std::size_t n) {
  const SphereTreeNode& node = tree_.nodes[n];
  for (std::size_t k = 0; k < kTreeWidth; ++k) {
    if ((node.used >> k & 1U) == 0) continue;
    const std::int32_t child = node.child[k];
    const std::vector<std::int32_t> leaves = child < 0
                                                 ? std::vector<std::int32_t>{~child}
                                                 : leaves_below_[static_cast<std::size_t>(child)];
    note(bound(n, k), leaves);
    leaves_below_[n].insert(leaves_below_[n].end(), leaves.begin(), leaves.end());
  }
}

Sphere TreeInspector::bound(std::size_t n, std::size_t k) const {
  const SphereTreeNode& node = tree_.nodes[n];
  return {{node.x[k], node.y[k], node.z[k]}, node.r[k]};
}

void TreeInspector::note(const Sphere& bound, const std::vector<std::int32_t>& leaves) {
  for (const std::int32_t i : leaves) {
    const Sphere& leaf = spheres_[static_cast<std::size_t>(i)];
    long double square = 0;
    for (int k = 0; k < 3; ++k) {
      const long double part = static_cast<long double>(leaf.p[k]) - bound.p[k];
      square += part * part;
    }
    worst_ = std::max(worst_, std::sqrt(square) + leaf.r - bound.r);
  }
}

std::vector<Sphere> leaves_of(const SphereTreeView& tree) {
  std::vector<Sphere> leaves;
  leaves.reserve(tree.leaf_r.size());
  for (std::size_t i = 0; i < tree.leaf_r.size(); ++i) {
    leaves.push_back(tree.leaf(static_cast<std::int32_t>(i)));
  }
  return leaves;
}

}  // namespace hapticd::test
