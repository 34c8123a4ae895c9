// What the contact problem of one tool keeps from tick to tick. Frames: W unless the name says
// otherwise. SI. RT: yes, plain data.
#pragma once

#include <array>
#include <limits>

#include "core/collision/query.h"
#include "core/contact/grip.h"
#include "core/contact/soft_part.h"
#include "core/contact/touched_string.h"
#include "core/math/limits.h"
#include "core/math/pose.h"
#include "core/math/wrench.h"

namespace hapticd {

/// A pair that carried force, and how much.
struct ActivePair {
  ContactKey key;
  double multiplier = 0.0;  ///< N
};

/// State of one tool from tick to tick.
struct ContactState {
  Pose X_WG;                        ///< last committed pose
  Vector3 phi_GH_W{0.0, 0.0, 0.0};  ///< last rotation error: the branch latch
  Wrench F_H_W;                     ///< last force from multipliers
  int active_count = 0;             ///< pairs that carried force last: warm start and curvature
  std::array<ActivePair, kMaxQpUnknowns> active;
  TouchedStrings touched;  ///< strings touched: how they are bent and what sticks to them
  TouchedParts parts;      ///< soft parts that are touched or displaced
  Grips grips;             ///< rigid objects that friction holds the tool on
  /// Levels of the options at the last tick that began without force: bounds are another shape, and
  /// what is pressed keeps its own until it is let go of.
  int tool_level = kLeafLevel;
  int body_level = kLeafLevel;
  Pose X_WH;            ///< of the last tick
  double travel = 0.0;  ///< of any point of the tool in the last tick, at most, m
  /// Kept from what is touched, m; no more than the skin counts.
  double clearance = std::numeric_limits<double>::infinity();
};

}  // namespace hapticd
