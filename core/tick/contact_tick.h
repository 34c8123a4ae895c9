// A contact of a tick, for those who look, and the name of the pair it is of. Frame: W. SI. Plain
// data. RT: yes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/math/vector.h"

namespace hapticd {

enum class ObstacleKind : std::uint8_t { kCapsule, kBody };
inline constexpr int kMaxObstacleKind = static_cast<int>(ObstacleKind::kBody);

/// True of a capsule: a string, or a line that does not sound.
[[nodiscard]] constexpr bool is_string(ObstacleKind kind) noexcept {
  return kind == ObstacleKind::kCapsule;
}
/// True of a body.
[[nodiscard]] constexpr bool is_body(ObstacleKind kind) noexcept {
  return kind == ObstacleKind::kBody;
}

/// Which pair of primitives touches; equal keys in two ticks are the same physical pair.
struct ContactKey {
  ObstacleKind kind = ObstacleKind::kCapsule;
  std::int32_t obstacle = 0;     ///< index among the capsules, or among the bodies
  std::int32_t tool_sphere = 0;  ///< in the tool's tree
  /// In the body's tree; of a capsule its leg (string_bend.h), 0 when straight.
  std::int32_t obstacle_sphere = 0;

  friend bool operator==(const ContactKey&, const ContactKey&) = default;
};

/// Of the obstacle of the pair.
[[nodiscard]] constexpr bool is_string(const ContactKey& key) noexcept {
  return is_string(key.kind);
}
[[nodiscard]] constexpr bool is_body(const ContactKey& key) noexcept { return is_body(key.kind); }

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
