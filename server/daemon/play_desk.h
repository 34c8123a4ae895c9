// What moves the hands: poses of clients for ticks to come, and gestures. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "server/daemon/loop_desk.h"
#include "server/daemon/scene_desk.h"

namespace hapticd {

class PlayDesk {
 public:
  /// All outlive this.
  PlayDesk(const PlayerOptions& player, const SceneDesk& scenes, LoopDesk& loop)
      : player_(player), scenes_(scenes), loop_(loop) {}

  /// Gives each tool's poses to the ticks from the batch's first one on, or behind those it has.
  [[nodiscard]] Answer queue_poses(const v1::PoseBatch& batch);
  [[nodiscard]] Answer play_gesture(const RequestId& id, const v1::PlayGesture& play);
  /// Poses that were given are not played any more: another scene plays, the lease is over, or a
  /// fault has ended a Run.
  void forget_poses() noexcept { next_ticks_ = {}; }

 private:
  [[nodiscard]] Answer fault_of(const v1::PoseSample& sample, const std::string& path) const;

  const PlayerOptions& player_;
  const SceneDesk& scenes_;
  LoopDesk& loop_;
  std::array<std::uint64_t, kMaxTools> next_ticks_{};  ///< of each tool, behind the last pose
};

}  // namespace hapticd
