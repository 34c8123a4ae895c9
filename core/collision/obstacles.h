// What the tool can touch, as the collision stage sees it: spans over the scene's memory. RT: yes.
#pragma once

#include <span>

#include "core/geometry/capsule.h"
#include "core/geometry/sphere_tree_view.h"
#include "core/math/pose.h"

namespace hapticd {

/// A rigid body of the scene: its tree and where it stands.
struct BodyView {
  SphereTreeView tree;
  Pose X_WB;
};

/// All obstacles: strings and rigid lines as capsules in W, bodies as sphere-trees.
struct ObstaclesView {
  std::span<const Capsule> capsules_W;
  std::span<const BodyView> bodies;
};

}  // namespace hapticd
