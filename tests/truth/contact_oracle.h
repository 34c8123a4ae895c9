// The truth about contacts, by exhaustion: every sphere of the tool against every capsule and every
// sphere of every body, in long double, straight from the definition of the distance. Shares no
// code with core/collision. Frames and units as in core/collision/contact.h. Not RT.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/collision/contact.h"
#include "core/geometry/capsule.h"
#include "core/geometry/sphere.h"
#include "core/math/pose.h"

namespace hapticd {

/// A body: its leaf spheres in B and where it is.
struct OracleBody {
  std::span<const Sphere> spheres_B;
  Pose X_WB;
  /// Width over which its spheres blend into one surface, m; 0: they do not. exhaustive_contacts
  /// knows none.
  double blend = 0.0;
};

/// A string bent to a vertex, which goes straight from p_WP_from to p_WP_to along a path.
struct OracleBentString {
  Capsule straight_W;
  Vector3 p_WP_from;
  Vector3 p_WP_to;
};

/// Everything the tool can touch.
struct OracleObstacles {
  std::span<const Capsule> capsules_W;
  std::span<const OracleBody> bodies;
  std::span<const OracleBentString> bent{};  ///< path_minimum_gap alone looks at them
};

struct OracleContact {
  ContactKey key;
  long double gap;       ///< m
  long double lambda;    ///< along the capsule's axis; 0 for a body
  long double distance;  ///< from the obstacle's axis or centre to the tool sphere's centre, m
  std::array<long double, 3> offset_W;  ///< the vector of that distance; not normalised
};

struct OracleResult {
  std::vector<OracleContact> contacts;  ///< all pairs with gap < margin, ordered by gap, then key
  long double minimum_gap;              ///< over all pairs; +infinity without obstacles
};

/// All pairs of `tool_G` at `X_WG` nearer than `margin`, and the smallest gap. About 50 ns per
/// pair.
[[nodiscard]] OracleResult exhaustive_contacts(std::span<const Sphere> tool_G, const Pose& X_WG,
                                               const OracleObstacles& obstacles,
                                               long double margin);

/// The smallest gap alone, exact to about 1e-18 of the lengths involved: every pair is evaluated in
/// double, those that could be the smallest again in long double. That to a blended body solves the
/// equation of core/collision/blended_surface.h by halving, over all its spheres. About 3 ns per
/// pair.
[[nodiscard]] long double exhaustive_minimum_gap(std::span<const Sphere> tool_G, const Pose& X_WG,
                                                 const OracleObstacles& obstacles);

/// The spheres of a tool where it stands.
struct OracleTool {
  std::span<const Sphere> spheres_G;
  const Pose& X_WG;
};

/// The smallest gap along the motion of a tool: translation linear in s, rotation exp(s phi)
/// R_begin with phi the rotation vector from the first to the last, its spheres straight in its
/// frame, sphere by sphere, with equal radii. By sphere tracing: between two places where the gap
/// is taken no point moves further than the gap at the first, or `spacing` (m, > 0) where that is
/// more, or an eighth of the way; the rest of the way is left out where it is shorter than the gap.
/// So nothing is missed but what two places `spacing` apart can hide. Bent strings move meanwhile;
/// their motion counts as way.
[[nodiscard]] long double path_minimum_gap(const OracleTool& begin, const OracleTool& end,
                                           const OracleObstacles& obstacles, long double spacing);

}  // namespace hapticd
