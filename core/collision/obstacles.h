// What the tool can touch, as the collision stage sees it: spans over the scene's memory. RT: yes.
#pragma once

#include <span>

#include "core/collision/string_bend.h"
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
  /// Capsules that are bent, in ascending order, each once.
  std::span<const StringBend> bends{};
};

/// The bend of capsule number `capsule`, null when it is straight. Bends are few.
[[nodiscard]] inline const StringBend* bend_of(const ObstaclesView& obstacles,
                                               std::int32_t capsule) noexcept {
  for (const StringBend& bend : obstacles.bends) {
    if (bend.capsule == capsule) return &bend;
  }
  return nullptr;
}

/// The segment that leg `leg` of a capsule names; all of a straight one.
[[nodiscard]] inline AxisSegment segment_of(const ObstaclesView& obstacles, std::int32_t capsule,
                                            std::int32_t leg) noexcept {
  const Capsule& straight = obstacles.capsules_W[static_cast<std::size_t>(capsule)];
  const StringBend* bend = bend_of(obstacles, capsule);
  return bend == nullptr ? AxisSegment{straight, 0, 0.0, 1.0} : leg_of(straight, *bend, leg);
}

/// Calls visit(capsule index, AxisSegment) for every straight capsule and every leg of a bent one.
template <typename Visit>
void for_each_segment(const ObstaclesView& obstacles, const Visit& visit) noexcept {
  auto bend = obstacles.bends.begin();
  std::int32_t index = 0;
  for (const Capsule& capsule : obstacles.capsules_W) {
    if (bend != obstacles.bends.end() && bend->capsule == index) {
      visit(index, leg_of(capsule, *bend, 0));
      visit(index, leg_of(capsule, *bend, 1));
      ++bend;
    } else {
      visit(index, AxisSegment{capsule, 0, 0.0, 1.0});
    }
    ++index;
  }
}

}  // namespace hapticd
