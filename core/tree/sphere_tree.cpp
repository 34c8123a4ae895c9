// Top-down builder: every node splits its leaves into up to eight groups by medians along the
// widest axis, with group sizes that keep all nodes below full (a node costs the same with one
// child as with eight). See sphere_tree.h.
#include "core/tree/sphere_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/geometry/closest_point.h"
#include "core/tree/enclosing_sphere.h"

namespace hapticd {
namespace {

/// Largest coordinate or radius accepted, m: squares of differences stay finite.
constexpr double kMaxCoordinate = 1e150;
/// Most leaves accepted: ids of bounds stay within 32 bits and the depth below kMaxTreeDepth.
constexpr std::size_t kMaxLeaves = std::size_t{1} << 24U;

using Members = std::span<std::int32_t>;

void check_leaves(std::span<const Sphere> leaves) {
  if (leaves.empty()) throw std::invalid_argument("sphere tree: no leaf spheres");
  if (leaves.size() > kMaxLeaves) throw std::invalid_argument("sphere tree: too many leaf spheres");
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Sphere& leaf = leaves[i];
    const bool centre_ok = (leaf.p.array().abs() <= kMaxCoordinate).all();
    if (!centre_ok || !(leaf.r >= 0.0) || !(leaf.r <= kMaxCoordinate)) {
      throw std::invalid_argument("sphere tree: leaf " + std::to_string(i) +
                                  ": centre must be finite and radius finite and >= 0");
    }
  }
}

/// Leaves a full subtree of `levels` levels of nodes holds: 8^levels.
std::size_t capacity(int levels) { return std::size_t{1} << (3U * static_cast<unsigned>(levels)); }

int levels_for(std::size_t leaves) {
  int levels = 1;
  while (capacity(levels) < leaves) ++levels;
  return levels;
}

int widest_axis(std::span<const Sphere> leaves, Members members) {
  Vector3 low = leaves[static_cast<std::size_t>(members.front())].p;
  Vector3 high = low;
  for (const std::int32_t i : members) {
    low = low.cwiseMin(leaves[static_cast<std::size_t>(i)].p);
    high = high.cwiseMax(leaves[static_cast<std::size_t>(i)].p);
  }
  const Vector3 extent = high - low;
  int axis = 0;
  if (extent.y() > extent[axis]) axis = 1;
  if (extent.z() > extent[axis]) axis = 2;
  return axis;
}

/// Groups of `group_size` members (the last may be smaller), neighbours together: halved across the
/// widest axis until each part is one group.
std::vector<Members> split(std::span<const Sphere> leaves, Members members,
                           std::size_t group_size) {
  std::vector<Members> groups;
  std::vector<Members> rest{members};
  while (!rest.empty()) {
    const Members part = rest.back();
    rest.pop_back();
    const std::size_t count = (part.size() + group_size - 1) / group_size;
    if (count == 1) {
      groups.push_back(part);
      continue;
    }
    const int axis = widest_axis(leaves, part);
    std::sort(part.begin(), part.end(), [&](std::int32_t a, std::int32_t b) {
      const double pa = leaves[static_cast<std::size_t>(a)].p[axis];
      const double pb = leaves[static_cast<std::size_t>(b)].p[axis];
      return pa != pb ? pa < pb : a < b;
    });
    const std::size_t left = (count / 2) * group_size;
    rest.push_back(part.subspan(left));
    rest.push_back(part.first(left));
  }
  return groups;
}

SphereTreeNode empty_node() {
  SphereTreeNode node;
  node.x.fill(0.0);
  node.y.fill(0.0);
  node.z.fill(0.0);
  node.r.fill(-std::numeric_limits<double>::infinity());
  node.child.fill(kNoChild);
  node.used = 0;
  node.inner = 0;
  return node;
}

void set_slot(SphereTreeNode& node, std::size_t slot, const Sphere& bound, std::int32_t child) {
  node.x[slot] = bound.p.x();
  node.y[slot] = bound.p.y();
  node.z[slot] = bound.p.z();
  node.r[slot] = bound.r;
  node.child[slot] = child;
  node.used |= 1U << slot;
  if (child >= 0) node.inner |= 1U << slot;
}

/// A node whose slots are still to be filled.
struct Pending {
  Members members;
  int level;  ///< 1 = root
};

}  // namespace

SphereTreeView SphereTree::view() const noexcept {
  return {nodes, leaf_x, leaf_y, leaf_z, leaf_r, bound, depth, overhang, boxes, blend};
}

void blend_surface(double width, SphereTree& tree) {
  tree.blend = {};
  if (!(width > 0.0)) return;
  tree.blend = {width, *std::min_element(tree.leaf_r.begin(), tree.leaf_r.end())};
}

std::vector<std::int32_t> spheres_per_level(const SphereTree& tree) {
  std::vector<std::int32_t> spheres;
  std::int32_t leaves_above = 0;
  // A level of nodes is a range of them: its inner slots are the next one.
  std::size_t begin = 0;
  std::size_t end = 1;
  while (begin < end && end <= tree.nodes.size()) {
    std::int32_t inner = 0;
    std::int32_t leaves = 0;
    for (std::size_t n = begin; n < end; ++n) {
      inner += std::popcount(tree.nodes[n].inner);
      leaves += std::popcount(tree.nodes[n].used & ~tree.nodes[n].inner);
    }
    spheres.push_back(leaves_above + inner + leaves);
    leaves_above += leaves;
    begin = end;
    end += static_cast<std::size_t>(inner);
  }
  return spheres;
}

// Visits every bound with all bounds above it.
double largest_overhang(const SphereTree& tree) {
  // above[n]: the bound of node n, and the node that holds it.
  struct Place {
    Sphere bound;
    std::size_t node;
  };
  std::vector<Place> above(tree.nodes.size(), {tree.bound, 0});
  double overhang = 0.0;
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const SphereTreeNode& node = tree.nodes[n];
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      if (node.child[k] < 0) continue;
      const Sphere bound{{node.x[k], node.y[k], node.z[k]}, node.r[k]};
      above[static_cast<std::size_t>(node.child[k])] = {bound, n};
      std::size_t m = n;
      for (bool more = true; more; m = above[m].node) {
        more = m != 0;
        const double reach = length(bound.p - above[m].bound.p) + bound.r;
        overhang = std::max(overhang, reach - above[m].bound.r);
      }
    }
  }
  return overhang;
}

// Children come after their node: from the last node on, those below are known.
std::vector<NodeBox> bounding_boxes(const SphereTree& tree) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<NodeBox> boxes(tree.nodes.size(),
                             {Vector3::Constant(kInfinity), Vector3::Constant(-kInfinity)});
  for (std::size_t n = tree.nodes.size(); n-- > 0;) {
    const SphereTreeNode& node = tree.nodes[n];
    NodeBox& box = boxes[n];
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      if ((node.used >> k & 1U) == 0) continue;
      const Vector3 p(node.x[k], node.y[k], node.z[k]);
      const Vector3 r = Vector3::Constant(node.r[k]);
      NodeBox below{p - r, p + r};
      if (node.child[k] >= 0) below = boxes[static_cast<std::size_t>(node.child[k])];
      box = {box.lower.cwiseMin(below.lower), box.upper.cwiseMax(below.upper)};
    }
  }
  return boxes;
}

SphereTree build_sphere_tree(std::span<const Sphere> leaves) {
  check_leaves(leaves);
  SphereTree tree;
  std::vector<std::int32_t> order;
  for (const Sphere& leaf : leaves) {
    order.push_back(static_cast<std::int32_t>(order.size()));
    tree.leaf_x.push_back(leaf.p.x());
    tree.leaf_y.push_back(leaf.p.y());
    tree.leaf_z.push_back(leaf.p.z());
    tree.leaf_r.push_back(leaf.r);
  }
  tree.bound = enclosing_sphere(leaves, order);

  // `pending[i]` is node i: breadth-first.
  std::vector<Pending> pending{{order, 1}};
  tree.nodes.push_back(empty_node());
  for (std::size_t n = 0; n < pending.size(); ++n) {
    const Pending current = pending[n];
    tree.depth = std::max(tree.depth, current.level);
    const std::vector<Members> groups =
        split(leaves, current.members, capacity(levels_for(current.members.size()) - 1));
    for (std::size_t slot = 0; slot < groups.size(); ++slot) {
      const Members group = groups[slot];
      std::int32_t child = ~group.front();
      if (group.size() > 1) {
        child = static_cast<std::int32_t>(pending.size());
        pending.push_back({group, current.level + 1});
        tree.nodes.push_back(empty_node());
      }
      set_slot(tree.nodes[n], slot, enclosing_sphere(leaves, group), child);
    }
  }
  tree.overhang = largest_overhang(tree);
  tree.boxes = bounding_boxes(tree);
  return tree;
}

}  // namespace hapticd
