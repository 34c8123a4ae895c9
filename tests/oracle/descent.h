// The hierarchical descent of a tool's sphere-tree against one capsule, level by level, for a page
// of the report (the paper's Fig. 6): which bounds were looked at and which were kept. Frame W. SI.
// Not RT.
#pragma once

#include <vector>

#include "core/geometry/capsule.h"
#include "core/geometry/sphere_tree_view.h"
#include "core/math/pose.h"

namespace hapticd {

/// A bound, or a leaf, that was looked at.
struct DescentSphere {
  Sphere sphere_W;
  TreeSphereId id = 0;
  bool leaf = false;
  bool kept = false;  ///< it overlaps the capsule grown by the margin
};

/// Per level, from the root's children down, the spheres looked at: the children of what was kept
/// one level higher.
using Descent = std::vector<std::vector<DescentSphere>>;

[[nodiscard]] Descent descend(const SphereTreeView& tree, const Pose& X_WG,
                              const Capsule& capsule_W, double margin);

/// The way that brings the sphere of the tool that is nearest to the capsule `depth` (m) into it,
/// straight along their distance.
[[nodiscard]] Vector3 way_into(const SphereTreeView& tree, const Pose& X_WG,
                               const Capsule& capsule_W, double depth);

}  // namespace hapticd
