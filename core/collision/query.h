// The collision query of the tick: tool tree against capsules (Eq. 1-4) and against body trees,
// hierarchical, detected around the GRAPHIC tool. One traversal returns every pair nearer than the
// margin and the true minimum gap to all obstacles. RT: yes; work is bounded by the pairs of the
// trees and counted in ContactSet::tests.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "core/collision/contact.h"
#include "core/collision/displaced_parts.h"
#include "core/collision/obstacles.h"
#include "core/math/realtime.h"

namespace hapticd {

/// Level that never stops early: pairs of leaves.
inline constexpr int kLeafLevel = std::numeric_limits<int>::max();

struct QueryOptions {
  double margin = 5e-3;  ///< pairs with gap below this are returned, m, > 0
  /// The minimum gap is searched up to this distance, m; >= margin. Infinity: always the true one.
  double horizon = std::numeric_limits<double>::infinity();
  /// Levels at which bounds are taken for the surface itself: 1 = the root's children.
  /// Conservative: the tool or body feels fatter by the bound's slack, and never sinks in. The
  /// error is reported by hapticd-model.
  int tool_level = kLeafLevel;
  int body_level = kLeafLevel;
};

/// A tool where it stands. Views what it is made from.
struct ToolView {
  const SphereTreeView& tree;  ///< in G
  const Pose& X_WG;
  DisplacedParts displaced{};
};

/// Fills `out` with all pairs of `tool` against `obstacles`. Gaps are exact (double
/// precision primitives), to rounding. Displaced parts cost one more traversal each, and take
/// kLeafLevel of the tool; with them the minimum gap beyond the margin is a lower bound.
HD_REALTIME void find_contacts(const ToolView& tool, const ObstaclesView& obstacles,
                               const QueryOptions& options, ContactSet& out) noexcept;

/// The same pair of primitives where the tool is now: gap, normal, point and lambda afresh. About
/// 30 ns.
[[nodiscard]] HD_REALTIME Contact evaluate_contact(const ContactKey& key, const ToolView& tool,
                                                   const ObstaclesView& obstacles) noexcept;

/// What an obstacle is where it is touched: round about a point, or about an axis.
struct RoundObstacle {
  double r;        ///< m; infinite where it is flat
  Vector3 axis_W;  ///< unit; zero: it is round on all sides
};

/// The obstacle of a contact that evaluate_contact() has found between the same; not of a blended
/// surface, see blend_curvature().
[[nodiscard]] HD_REALTIME RoundObstacle round_obstacle(const Contact& contact, const ToolView& tool,
                                                       const ObstaclesView& obstacles) noexcept;

/// How the normal of a blended surface turns as the centre of the tool's sphere moves, 1/m:
/// BlendedPlace::curvature_B in W. `key`: with such a surface.
[[nodiscard]] HD_REALTIME Matrix3 blend_curvature(const ContactKey& key, const ToolView& tool,
                                                  const ObstaclesView& obstacles) noexcept;

/// Whether there is the obstacle that `key` names, and what of it.
[[nodiscard]] HD_REALTIME bool has_obstacle(const ContactKey& key,
                                            const ObstaclesView& obstacles) noexcept;

/// The same for all of `contacts`, in place; minimum_gap becomes the smallest of their gaps, m, or
/// +infinity when there are none. About 10 ns per contact.
HD_REALTIME void evaluate_contacts(const ToolView& tool, const ObstaclesView& obstacles,
                                   ContactSet& contacts) noexcept;

/// Smallest gap over the pairs already in `contacts`, where the tool is now, m; +infinity when
/// there are none.
[[nodiscard]] HD_REALTIME double minimum_gap_of(const ContactSet& contacts, const ToolView& tool,
                                                const ObstaclesView& obstacles) noexcept;

/// Some of the contacts of a set, by their places in it.
struct ContactSubset {
  const ContactSet& set;
  std::span<const std::int32_t> which;
};

/// True when one of these pairs has a gap below `least` (m) where the tool is now. About 15 ns per
/// pair.
[[nodiscard]] HD_REALTIME bool any_gap_below(double least, const ContactSubset& contacts,
                                             const ToolView& tool,
                                             const ObstaclesView& obstacles) noexcept;

}  // namespace hapticd
