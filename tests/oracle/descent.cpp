// See descent.h.
#include "tests/oracle/descent.h"

#include <limits>
#include <utility>

#include "core/geometry/closest_point.h"

namespace hapticd {
namespace {

SegmentPoint nearest(const Capsule& capsule, const Vector3& p_W) {
  return closest_point_on_segment(capsule.p_A, capsule.p_B, p_W);
}

}  // namespace

Descent descend(const SphereTreeView& tree, const Pose& X_WG, const Capsule& capsule_W,
                double margin) {
  Descent descent;
  std::vector<std::int32_t> nodes{0};
  while (!nodes.empty()) {
    std::vector<std::int32_t> next;
    std::vector<DescentSphere> level;
    for (const std::int32_t index : nodes) {
      const SphereTreeNode& node = tree.nodes[static_cast<std::size_t>(index)];
      for (int slot = 0; slot < kTreeWidth; ++slot) {
        const auto k = static_cast<std::size_t>(slot);
        if (((node.used >> k) & 1U) == 0) continue;
        DescentSphere seen;
        seen.sphere_W = {transform(X_WG, {node.x[k], node.y[k], node.z[k]}), node.r[k]};
        seen.leaf = ((node.inner >> k) & 1U) == 0;
        seen.id = seen.leaf ? ~node.child[k] : bound_id(index, slot);
        const double distance = nearest(capsule_W, seen.sphere_W.p).distance;
        seen.kept = distance - seen.sphere_W.r - capsule_W.r < margin;
        if (seen.kept && !seen.leaf) next.push_back(node.child[k]);
        level.push_back(seen);
      }
    }
    descent.push_back(std::move(level));
    nodes = std::move(next);
  }
  return descent;
}

Vector3 way_into(const SphereTreeView& tree, const Pose& X_WG, const Capsule& capsule_W,
                 double depth) {
  double smallest = std::numeric_limits<double>::infinity();
  Vector3 way{0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < tree.leaf_r.size(); ++i) {
    const Sphere leaf = tree.leaf(static_cast<std::int32_t>(i));
    const SegmentPoint at = nearest(capsule_W, transform(X_WG, leaf.p));
    const double gap = at.distance - leaf.r - capsule_W.r;
    if (gap >= smallest) continue;
    smallest = gap;
    const Vector3 axis = capsule_W.p_B - capsule_W.p_A;
    way = -(gap + depth) * direction_or_fallback(at.offset, at.distance, axis);
  }
  return way;
}

}  // namespace hapticd
