// The contacts of a tick, for clients that look: every pair that bears force, and those nearer than
// twice the skin. Frames: W. SI. RT: yes, plain data.
#pragma once

#include <cstdint>

#include "core/collision/contact.h"
#include "core/math/fixed_vector.h"

namespace hapticd {

/// Contacts reported of a tick, at most: the deepest.
inline constexpr std::size_t kMaxReportedContacts = 256;

/// A pair that bears no force is reported while its gap is up to this many skins.
inline constexpr double kNearSkins = 2.0;

/// One pair of tool sphere and obstacle.
struct ContactReading {
  ContactKey key;
  std::int32_t part = 0;  ///< of the tool
  Array3 p_WC{};          ///< on the tool's surface, m
  Array3 nhat_OG_W{};     ///< unit, from the obstacle to the tool
  double lambda = 0.0;    ///< along a capsule, in [0, 1]
  double gap = 0.0;       ///< signed, m
  double force = 0.0;     ///< normal force on the tool, N; the solver's share of a redundant pair
};

/// Contacts of a tick, deepest first.
struct ContactReport {
  FixedVector<ContactReading, kMaxReportedContacts> contacts;
  std::int32_t total = 0;  ///< with those that found no place
};

}  // namespace hapticd
