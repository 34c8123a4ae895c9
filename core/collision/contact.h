// One candidate contact between a sphere of the graphic tool and an obstacle (a capsule or a sphere
// of a body):
//   gap = |C_tool - P_obstacle| - r_tool - r_obstacle,   nhat_OG_W = (C_tool - P_obstacle) / |...|
//   (from obstacle to tool)
// with P the nearest point of the capsule's axis or the body sphere's centre. Frame W unless the
// name says otherwise. RT: yes, plain data.
#pragma once

#include <cstdint>

#include "core/geometry/sphere_tree_view.h"
#include "core/math/fixed_vector.h"
#include "core/math/limits.h"
#include "core/tick/contact_tick.h"

namespace hapticd {

struct Contact {
  ContactKey key;
  Vector3 nhat_OG_W;  ///< unit, from the obstacle to the tool
  Vector3 p_WC;       ///< contact point: on the tool sphere's surface, nearest to the obstacle, m
  double gap;         ///< signed distance, m; negative = penetrating
  double lambda;      ///< position along the capsule's axis in [0, 1]; 0 for a body
};

/// Result of one query, ordered by nothing in particular but deterministically.
struct ContactSet {
  /// Every pair with gap < covered_margin, and none with a larger one; one with that very gap only
  /// when there were more than kMaxCandidates, the most that a query leaves.
  FixedVector<Contact, kMaxCandidates + kSpareCandidates> contacts;
  /// The margin asked for, or less when there were more pairs than that: the gap of the nearest
  /// omitted pair, m.
  double covered_margin = 0.0;
  /// True smallest gap to all obstacles, m, when it is below the query's horizon; otherwise the
  /// horizon.
  double minimum_gap = 0.0;
  /// Pairs of spheres or bounds evaluated: the work count of the tick's budget.
  std::int64_t tests = 0;
};

}  // namespace hapticd
