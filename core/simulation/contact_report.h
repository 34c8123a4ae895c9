// The contacts of a tick, for clients that look: every pair that bears force, and those nearer than
// twice the skin. Frames: W. SI. RT: yes.
#pragma once

#include <cstdint>

#include "core/math/fixed_vector.h"
#include "core/math/realtime.h"
#include "core/simulation/tool_play.h"
#include "core/tick/contact_tick.h"

namespace hapticd {

/// A pair that bears no force is reported while its gap is up to this many skins.
inline constexpr double kNearSkins = 2.0;

/// Contacts of a tick, deepest first.
struct ContactReport {
  FixedVector<ContactTick, kMaxReportedContacts> contacts;
  std::int32_t total = 0;  ///< with those that found no place
};

/// The contacts of tool number `tool` of `memory` as all stands after a tick: strings as all tools
/// bend them, who holds which being `sharing`. Cost: about 40 ns per listed pair, and 20 ns per leg
/// of a string that several tools hold.
HD_REALTIME void report_contacts(const SimulationMemory& memory, const StringSharing& sharing,
                                 std::size_t tool, ContactReport& report) noexcept;

}  // namespace hapticd
