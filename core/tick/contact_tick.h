// How a tool's contact problem ended in a tick; a contact of it, for those who look, and the name
// of the pair it is of. Frame: W. SI. Plain data. RT: yes.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

#include "core/math/vector.h"

namespace hapticd {

enum class ContactStatus : std::uint8_t {
  kFree,        ///< nothing in the way: G coincides with H
  kConverged,   ///< the wanted step fell below stop_tolerance
  kLagging,     ///< sub-steps or work used up before convergence
  kRefused,     ///< no admissible step found: G kept
  kQpFailed,    ///< solver gave up: G kept, force not larger than before
  kRecovering,  ///< a gap was negative at the start: being pushed out
};

/// The end of a contact problem. Written by it.
struct ContactOutcome {
  ContactStatus status = ContactStatus::kFree;
  int active_count = 0;     ///< pairs that carry force
  int strings_refused = 0;  ///< stayed rigid because kMaxDeflectingStrings are touched
  int rows_exchanged = 0;   ///< rows brought in because more pairs than rows mattered
  /// Of the contact problem: to anything at the last evaluated pose. Of a tick: as all stands after
  /// it, up to the margin. m
  double minimum_gap = 0.0;
  double residual_force = 0.0;  ///< KKT residual of the last program: stationarity, N
  double residual_gap = 0.0;    ///< and its worst row, m
};

/// Of which primitive an obstacle is; core/collision/obstacles.h lists them.
enum class ObstacleKind : std::uint8_t;

/// Which pair of primitives touches; equal keys in two ticks are the same physical pair. Ordered by
/// obstacle first.
struct ContactKey {
  ObstacleKind kind{};
  std::int32_t obstacle = 0;     ///< index among those of its kind
  std::int32_t tool_sphere = 0;  ///< in the tool's tree
  /// In the body's tree; of a capsule its leg (string_bend.h), 0 when straight.
  std::int32_t obstacle_sphere = 0;

  friend auto operator<=>(const ContactKey&, const ContactKey&) = default;
};

/// Contacts reported of a tick, at most: the deepest.
inline constexpr std::size_t kMaxReportedContacts = 256;

/// One pair of tool sphere and obstacle.
struct ContactTick {
  ContactKey key;
  std::int32_t part = 0;  ///< of the tool
  Array3 p_WC{};          ///< on the tool's surface, m
  Array3 nhat_OG_W{};     ///< unit, from the obstacle to the tool
  double lambda = 0.0;    ///< along a capsule, in [0, 1]
  double gap = 0.0;       ///< signed, m
  double force = 0.0;     ///< normal force on the tool, N; the solver's share of a redundant pair
};

}  // namespace hapticd
