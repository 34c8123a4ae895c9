// What the tool can touch: the kinds there are, and spans over the scene's memory. RT: yes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/collision/string_bend.h"
#include "core/geometry/capsule.h"
#include "core/geometry/sphere_tree_view.h"
#include "core/math/pose.h"
#include "core/tick/contact_tick.h"

namespace hapticd {

/// In the order of the primitives (primitives.h).
enum class ObstacleKind : std::uint8_t { kCapsule, kBody };
inline constexpr int kMaxObstacleKind = static_cast<int>(ObstacleKind::kBody);

/// True of a pair with a capsule: a string, or a line that does not sound.
[[nodiscard]] constexpr bool is_string(const ContactKey& key) noexcept {
  return key.kind == ObstacleKind::kCapsule;
}
/// True of a pair with a body.
[[nodiscard]] constexpr bool is_body(const ContactKey& key) noexcept {
  return key.kind == ObstacleKind::kBody;
}

/// True of a pair with the blended surface of a body: neither convex nor a sphere.
[[nodiscard]] constexpr bool is_blend(const ContactKey& key) noexcept {
  return is_body(key) && key.obstacle_sphere == kBlendedSurface;
}

/// A rigid body of the scene: its tree and where it is.
struct BodyView {
  SphereTreeView tree;
  Pose X_WB;
};

/// Capsules of one group: 16 in a row of ObstaclesView::capsules_W, the last group may have fewer.
inline constexpr std::size_t kCapsulesPerGroup = 16;

/// What bounds the capsules of a group, their radii included, in W.
struct CapsuleGroup {
  Vector3 lower;
  Vector3 upper;
};

class BlendMemory;

/// All obstacles: strings and rigid lines as capsules in W, bodies as sphere-trees.
struct ObstaclesView {
  std::span<const Capsule> capsules_W;
  std::span<const BodyView> bodies;
  /// Capsules that are bent, in ascending order, each once.
  std::span<const StringBend> bends{};
  /// Bounds of the capsules (group_capsules), so that far ones are passed over a group at a time;
  /// empty: each is looked at. To be rebuilt when capsules change.
  std::span<const CapsuleGroup> groups{};
  /// Bounds of all groups (box_of), where there are some: a tool far from every string looks at no
  /// more than this.
  CapsuleGroup all = {Vector3::Zero(), Vector3::Zero()};
  /// Where what is near the tool on blended surfaces is remembered, of one tool
  /// (blended_surface.h); null: it is looked for each time, and found the same.
  BlendMemory* blends = nullptr;
};

/// The segment that leg `leg` of a capsule names; all of a straight one. Bends are few.
[[nodiscard]] inline AxisSegment segment_of(const ObstaclesView& obstacles, std::int32_t capsule,
                                            std::int32_t leg) noexcept {
  const Capsule& straight = obstacles.capsules_W[static_cast<std::size_t>(capsule)];
  for (const StringBend& bend : obstacles.bends) {
    if (bend.capsule == capsule) return leg_of(straight, bend, leg);
  }
  return {straight, 0, 0.0, 1.0};
}

/// A ball: what may be near the tool.
struct Neighbourhood {
  Vector3 p_W;
  double radius;  ///< m; infinite: everything
};

/// The box of a straight capsule.
[[nodiscard]] inline CapsuleGroup box_of(const Capsule& capsule) noexcept {
  const Vector3 r = Vector3::Constant(capsule.r);
  return {capsule.p_A.cwiseMin(capsule.p_B) - r, capsule.p_A.cwiseMax(capsule.p_B) + r};
}

/// The box around two boxes.
[[nodiscard]] inline CapsuleGroup box_of(const CapsuleGroup& a, const CapsuleGroup& b) noexcept {
  return {a.lower.cwiseMin(b.lower), a.upper.cwiseMax(b.upper)};
}

/// Bounds of group number `group` of `capsules`.
[[nodiscard]] inline CapsuleGroup group_capsules(std::span<const Capsule> capsules,
                                                 std::size_t group) noexcept {
  const std::size_t first = group * kCapsulesPerGroup;
  CapsuleGroup box = box_of(capsules[first]);
  for (std::size_t i = first + 1; i < std::min(first + kCapsulesPerGroup, capsules.size()); ++i) {
    box = box_of(box, box_of(capsules[i]));
  }
  return box;
}

/// Bounds of all of `groups`; nothing in particular where there are none.
[[nodiscard]] inline CapsuleGroup box_of(std::span<const CapsuleGroup> groups) noexcept {
  if (groups.empty()) return {Vector3::Zero(), Vector3::Zero()};
  CapsuleGroup box = groups.front();
  for (const CapsuleGroup& group : groups.subspan(1)) box = box_of(box, group);
  return box;
}

/// How far `p` is outside [lower, upper], squared; 0 inside.
[[nodiscard]] inline double squared_outside(double lower, double upper, double p) noexcept {
  const double below = lower - p;
  const double above = p - upper;
  const double outside = below > above ? below : above;
  return outside > 0.0 ? outside * outside : 0.0;
}

/// False when the box is certainly outside `near`. Strings lie side by side, so that one axis
/// separates most of them: where it is too far by itself, so is the sum. 5 to 15 operations.
[[nodiscard]] inline bool may_touch(const CapsuleGroup& box, const Neighbourhood& near) noexcept {
  const double most = near.radius * near.radius;
  const double z = squared_outside(box.lower.z(), box.upper.z(), near.p_W.z());
  if (z > most) return false;
  const double y = squared_outside(box.lower.y(), box.upper.y(), near.p_W.y());
  if (y > most) return false;
  const double x = squared_outside(box.lower.x(), box.upper.x(), near.p_W.x());
  return !((x + y) + z > most);
}

/// What of box_of(capsule) lies along one axis, as in may_touch().
[[nodiscard]] inline double squared_outside(const Capsule& capsule, Eigen::Index axis,
                                            double p) noexcept {
  const double a = capsule.p_A[axis];
  const double b = capsule.p_B[axis];
  return squared_outside((a < b ? a : b) - capsule.r, (a > b ? a : b) + capsule.r, p);
}

/// may_touch() of the box of a straight capsule, of which no more is made than is looked at.
[[nodiscard]] inline bool capsule_may_touch(const Capsule& capsule,
                                            const Neighbourhood& near) noexcept {
  const double most = near.radius * near.radius;
  const double z = squared_outside(capsule, 2, near.p_W.z());
  if (z > most) return false;
  const double y = squared_outside(capsule, 1, near.p_W.y());
  if (y > most) return false;
  return !((squared_outside(capsule, 0, near.p_W.x()) + y) + z > most);
}

/// Calls visit(capsule index, AxisSegment) for every straight capsule that may touch `near`, and
/// for every leg of a bent one.
template <typename Visit>
[[gnu::always_inline]] inline void for_each_segment(const ObstaclesView& obstacles,
                                                    const Neighbourhood& near,
                                                    const Visit& visit) noexcept {
  const bool grouped = !obstacles.groups.empty();
  if (grouped && obstacles.bends.empty() && !may_touch(obstacles.all, near)) return;
  const auto capsules = static_cast<std::int32_t>(obstacles.capsules_W.size());
  constexpr auto kGroup = static_cast<std::int32_t>(kCapsulesPerGroup);
  auto bend = obstacles.bends.begin();
  for (std::int32_t first = 0; first < capsules; first += kGroup) {
    const std::int32_t end = first + kGroup < capsules ? first + kGroup : capsules;
    const bool bent_inside = bend != obstacles.bends.end() && bend->capsule < end;
    if (!bent_inside && grouped &&
        !may_touch(obstacles.groups[static_cast<std::size_t>(first / kGroup)], near)) {
      continue;
    }
    for (std::int32_t index = first; index < end; ++index) {
      const Capsule& capsule = obstacles.capsules_W[static_cast<std::size_t>(index)];
      if (bend != obstacles.bends.end() && bend->capsule == index) {
        visit(index, leg_of(capsule, *bend, 0));
        visit(index, leg_of(capsule, *bend, 1));
        ++bend;
      } else if (capsule_may_touch(capsule, near)) {
        visit(index, AxisSegment{capsule, 0, 0.0, 1.0});
      }
    }
  }
}

}  // namespace hapticd
