// Ticks as States of the wire. Not RT.
#pragma once

#include <cstdint>

#include "core/tick/tick.h"
#include "hapticd/v1/control.pb.h"
#include "hapticd/v1/state.pb.h"
#include "server/encoding/scene_index.h"

namespace hapticd {

/// Every section but TIMING, STAGES and REPLAY, as bits 1 << section.
inline constexpr std::uint32_t kCanonicalSections =
    1U << v1::SECTION_TOOLS | 1U << v1::SECTION_DEVICES | 1U << v1::SECTION_STRINGS |
    1U << v1::SECTION_CONTACTS | 1U << v1::SECTION_ENERGY | 1U << v1::SECTION_QUALITY |
    1U << v1::SECTION_STIFFNESS | 1U << v1::SECTION_GESTURES;

/// What is asked of a State.
struct StateRequest {
  std::uint32_t sections = 0;  ///< bits 1 << v1::Section
  /// Contacts listed at most, deepest first; contacts_total is set when there are more.
  std::uint32_t max_contacts = 256;
};

/// Fills `state`, which is cleared first, with the sections of `request` that a tick has:
/// all but TIMING, which needs more than one tick; STAGES has the times of this one alone.
void encode_state(const Tick& tick, const SceneIndex& index, const StateRequest& request,
                  v1::State& state);

}  // namespace hapticd
