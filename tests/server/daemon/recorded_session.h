// A session of a loop with a scripted device, recorded as the daemon does: a string plucked, a wall
// touched, settings changed, force switched, faults, another scene; and recordings made of it: from
// a Snapshot on, or with one bit turned over.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/daemon/replay_run.h"
#include "server/daemon/scene_player.h"
#include "tests/server/haptic_loop/wall_scene.h"

namespace hapticd::test {

/// Ticks of the session.
inline constexpr int kSessionTicks = 3600;

/// Records it. Under real time instants are uneven and some periods are passed over.
void record_session(const std::string& path, bool virtual_time);

/// What plays of a recorded scene, for a replay.
std::unique_ptr<PlayedScene> replayed_scene(const v1::SceneRecord& record,
                                            const v1::RecordHeader& header);

/// Plays all of a recording, and compares.
ReplayReport verify(const std::string& path);

/// The recording `from` without what stands before its Snapshot number `snapshot`, 0 the first. As
/// a dump has it. False when it has not so many.
bool copy_from_snapshot(const std::string& from, int snapshot, const std::string& to);

/// A message of a recording.
struct CopiedMessage {
  RecordKind kind = RecordKind::kTick;
  std::string bytes;
};

/// All messages of a recording behind its header.
std::vector<CopiedMessage> messages_of(const std::string& path);

/// Writes a recording of these.
void write_recording(const std::string& path, const v1::RecordHeader& header,
                     const std::vector<CopiedMessage>& messages);

/// The recording `from` with each tick as `change` leaves it, but those for which it says false.
void copy_changed(const std::string& from, const std::string& to,
                  const std::function<bool(v1::TickRecord&)>& change);

}  // namespace hapticd::test
