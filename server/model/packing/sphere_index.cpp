// See sphere_index.h.
#include "server/model/packing/sphere_index.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/closest_point.h"

namespace hapticd {
namespace {

/// Spheres in a leaf of the tree. Normal value 4; see kLeafTriangles of mesh_distance.cpp.
constexpr std::int32_t kLeafSpheres = 4;
/// Depth of the stack of a search: the tree is halved by count, so at most 31 levels.
constexpr std::size_t kStack = 64;

}  // namespace

SphereIndex::SphereIndex(std::span<const Sphere> spheres) {
  for (const Sphere& s : spheres) {
    items_.push_back({s.p, s.r, static_cast<std::int32_t>(items_.size())});
  }
  if (items_.empty()) return;
  struct Range {
    std::int32_t node, first, count;
  };
  std::vector<Range> rest{{0, 0, static_cast<std::int32_t>(items_.size())}};
  nodes_.resize(1);
  while (!rest.empty()) {
    const Range range = rest.back();
    rest.pop_back();
    const auto begin = items_.begin() + range.first;
    const auto end = begin + range.count;
    Node node{begin->p, begin->p, begin->r, range.first, range.count};
    for (auto i = begin; i != end; ++i) {
      node.low = node.low.cwiseMin(i->p);
      node.high = node.high.cwiseMax(i->p);
      node.r = std::max(node.r, i->r);
    }
    if (range.count > kLeafSpheres) {
      const Vector3 extent = node.high - node.low;
      int axis = extent.y() > extent.x() ? 1 : 0;
      if (extent.z() > extent[axis]) axis = 2;
      const std::int32_t left = range.count / 2;
      // Sorted, not only partitioned: the order of items is the order of answers.
      std::sort(begin, end, [&](const Item& s, const Item& t) {
        return s.p[axis] != t.p[axis] ? s.p[axis] < t.p[axis] : s.id < t.id;
      });
      node.first = static_cast<std::int32_t>(nodes_.size());
      node.count = 0;
      nodes_.resize(nodes_.size() + 2);
      rest.push_back({node.first + 1, range.first + left, range.count - left});
      rest.push_back({node.first, range.first, left});
    }
    nodes_[static_cast<std::size_t>(range.node)] = node;
  }
}

double SphereIndex::least_gap(const Node& node, const Vector3& p) noexcept {
  const Vector3 out = (node.low - p).cwiseMax(p - node.high).cwiseMax(0.0);
  return length(out) - node.r;
}

NearestSphere SphereIndex::nearest(const Vector3& p) const noexcept {
  struct Entry {
    double gap;
    std::int32_t node;
  };
  NearestSphere best;
  std::array<Entry, kStack> stack;
  std::size_t size = 0;
  if (!nodes_.empty()) stack[size++] = {least_gap(nodes_[0], p), 0};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.gap > best.gap) continue;
    const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
    if (node.count == 0) {
      Entry near{least_gap(nodes_[static_cast<std::size_t>(node.first)], p), node.first};
      Entry far{least_gap(nodes_[static_cast<std::size_t>(node.first) + 1], p), node.first + 1};
      if (far.gap < near.gap) std::swap(near, far);
      if (far.gap <= best.gap) stack[size++] = far;
      if (near.gap <= best.gap) stack[size++] = near;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const Item& item = items_[static_cast<std::size_t>(i)];
      const double gap = length(p - item.p) - item.r;
      if (gap < best.gap || (gap == best.gap && item.id < best.sphere)) best = {gap, item.id};
    }
  }
  return best;
}

template <typename Visit>
bool SphereIndex::any_within(const Vector3& p, double gap, const Visit& visit) const {
  std::array<std::int32_t, kStack> stack;
  std::size_t size = 0;
  if (!nodes_.empty()) stack[size++] = 0;
  while (size > 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[--size])];
    if (least_gap(node, p) > gap) continue;
    if (node.count == 0) {
      stack[size++] = node.first + 1;
      stack[size++] = node.first;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const Item& item = items_[static_cast<std::size_t>(i)];
      const double its_gap = length(p - item.p) - item.r;
      if (its_gap <= gap && visit(item.id, its_gap)) return true;
    }
  }
  return false;
}

bool SphereIndex::inside_another(const Vector3& p, std::int32_t except, double depth) const {
  return any_within(p, -depth,
                    [&](std::int32_t id, double gap) { return id != except && gap < -depth; });
}

void SphereIndex::within(const Vector3& p, double gap, std::vector<std::int32_t>& found) const {
  any_within(p, gap, [&](std::int32_t id, double) {
    found.push_back(id);
    return false;
  });
}

}  // namespace hapticd
