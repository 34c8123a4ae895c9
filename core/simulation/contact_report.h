// The contacts of a tick, for clients that look: every pair that bears force, and those nearer than
// twice the skin. Frames: W. SI. RT: yes.
#pragma once

#include <cstdint>

#include "core/math/fixed_vector.h"
#include "core/math/realtime.h"
#include "core/tick/contact_tick.h"

namespace hapticd {

struct ToolPlay;

/// A pair that bears no force is reported while its gap is up to this many skins.
inline constexpr double kNearSkins = 2.0;

/// Contacts of a tick, deepest first.
struct ContactReport {
  FixedVector<ContactTick, kMaxReportedContacts> contacts;
  std::int32_t total = 0;  ///< with those that found no place
};

/// The contacts of a tool as they are after a tick. Cost: about 40 ns per listed pair.
HD_REALTIME void report_contacts(const ToolPlay& play, ContactReport& report) noexcept;

}  // namespace hapticd
