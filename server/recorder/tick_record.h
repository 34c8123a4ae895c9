// A tick as the loop leaves it in the form it is recorded in (TickRecord), and back: every double
// that a replay needs keeps its bits. Not RT.
#pragma once

#include "core/tick/tick.h"
#include "hapticd/v1/recording.pb.h"
#include "server/encoding/encode_state.h"

namespace hapticd {

/// Contacts that a recording shows of a tick, at most: the deepest. More: larger recordings.
inline constexpr std::uint32_t kShownContacts = 64;

/// Fills `record`, whose storage is used again, with what went in and came out: all that a replay
/// needs and compares.
void to_record(const Tick& tick, v1::TickRecord& record);

/// Adds what else clients were shown of the tick (TickRecord.shown): of tools what neither went in
/// nor came out, strings, contacts, energy, quality, stiffness, gestures and, on a real clock, the
/// times of its stages.
void add_shown(const Tick& tick, const SceneIndex& index, v1::TickRecord& record);

/// What to_record() told. False when `record` cannot be a tick of ours: more tools than there may
/// be, inputs and outputs that do not match, or numbers missing.
[[nodiscard]] bool to_tick(const v1::TickRecord& record, Tick& tick);

}  // namespace hapticd
