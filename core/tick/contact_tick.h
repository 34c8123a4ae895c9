// A contact of a tick, for those who look, and the name of the pair it is of. Frame: W. SI. Plain
// data. RT: yes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/math/vector.h"

namespace hapticd {

/// Of which primitive an obstacle is; core/collision/obstacles.h lists them.
enum class ObstacleKind : std::uint8_t;

/// Which pair of primitives touches; equal keys in two ticks are the same physical pair.
struct ContactKey {
  ObstacleKind kind{};
  std::int32_t obstacle = 0;     ///< index among those of its kind
  std::int32_t tool_sphere = 0;  ///< in the tool's tree
  /// In the body's tree; of a capsule its leg (string_bend.h), 0 when straight.
  std::int32_t obstacle_sphere = 0;

  friend bool operator==(const ContactKey&, const ContactKey&) = default;
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
