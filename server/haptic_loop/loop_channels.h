// What the loop exchanges with the other threads: rings of one writer and one reader each, and the
// words of the Stop road. RT: yes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/rt/owner_ring.h"
#include "core/rt/rt_log.h"
#include "core/rt/spsc_ring.h"
#include "core/tick/tick_ring.h"
#include "server/haptic_loop/loop_command.h"
#include "server/haptic_loop/loop_event.h"
#include "server/haptic_loop/played_scene.h"
#include "server/haptic_loop/settings_change.h"
#include "server/haptic_loop/snapshot.h"
#include "server/haptic_loop/stop_line.h"

namespace hapticd {

/// A pose for a tick, of a device that follows poses.
struct TickPose {
  std::uint64_t tick = 0;
  std::uint32_t tool = 0;   ///< in the scene's order
  std::uint64_t lease = 0;  ///< how many leases had ended when it was given
  QueuedPose pose;
};

/// Ticks on their way to the network: half a second of usual ones at 1 kHz, 13 of the fullest.
using NetworkTicks = TickRing<3U << 19U>;
/// Ticks on their way to the recorder: 3.7 s of usual ones, 65 of the fullest.
using RecorderTicks = TickRing<15U << 19U>;

/// What is lent to the loop and given back: two rings. No more than `Capacity` things may be with
/// the loop at a time, or on their way.
template <typename T, std::size_t Capacity>
struct Lending {
  OwnerRing<std::unique_ptr<T>, Capacity> lent;  ///< to the loop; each before its command
  OwnerRing<std::unique_ptr<T>, Capacity> back;  ///< not touched any more, to be freed

  /// Loop. There is room, since whoever lends counts.
  void give_back(std::unique_ptr<T> owner) noexcept {
    if (owner == nullptr) return;
    const bool has_room = back.push(owner);
    HD_ASSERT(has_room);
  }
};

struct LoopChannels {
  Lending<PlayedScene, 4> scenes;
  Lending<GesturePlan, 512> gestures;
  Lending<SettingsChange, 512> changes;
  SpscRing<LoopCommand, 256> commands;  ///< to the loop
  SpscRing<TickPose, kPoseQueue> poses;
  SpscRing<LoopEvent, 4096> events;  ///< lossless; an overflow is a fault
  SnapshotRing snapshots;            ///< to the recorder's thread, once a second
  NetworkTicks ticks;                ///< those that find no place are left out
  RecorderTicks recorded;  ///< to the recorder's thread; what does not fit is lost, and counted
  LogRing log;
  StopLine stop;  ///< with the Stop road's thread
};

}  // namespace hapticd
