// The haptic loop without its clock: one call of tick_once() reads the devices, advances the loop's
// state, steps the simulation, passes each tool's wrench through the safety stage, writes it, and
// tells the other threads. One state for all tools: they get force together, and the fault of one
// takes it from all. run_realtime() (realtime_thread.h) calls it on time; lockstep and tests call
// it as they like. Links no network, protobuf or log. RT: yes but for construction.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "core/rt/monotonic_clock.h"
#include "core/simulation/simulation.h"
#include "server/haptic_loop/loop_channels.h"
#include "server/haptic_loop/loop_snapshot.h"
#include "server/haptic_loop/orders.h"
#include "server/haptic_loop/publisher.h"
#include "server/haptic_loop/scene_slot.h"
#include "server/haptic_loop/stall_guard.h"

namespace hapticd {

/// Commands obeyed in one tick, at most; the others wait. A few, so that no sender can lengthen a
/// tick.
inline constexpr int kCommandsPerTick = 8;

/// Poses taken over in one tick, at most; a sender of one per tick is never waited for.
inline constexpr int kPosesPerTick = 64;

/// Fixed at construction.
struct LoopOptions {
  std::int64_t period_ns = 1'000'000;  ///< [1e5, 4e6]
  bool virtual_time = false;           ///< time is tick * period, from 0 with every scene
  bool guards_armed = false;      ///< late ticks, fast hands, stuck sensors latch for any device
  bool contacts_reported = true;  ///< ticks list contacts
  bool snapshots = true;          ///< a snapshot of all state goes out once a second
};

class HapticLoop {
 public:
  /// `first` plays from the first tick; `channels` must outlive the loop.
  HapticLoop(const LoopOptions& options, std::unique_ptr<PlayedScene> first,
             LoopChannels& channels);
  HapticLoop(const HapticLoop&) = delete;
  HapticLoop& operator=(const HapticLoop&) = delete;

  /// One tick at `now_ns` of the monotonic clock, `skipped` periods having been passed over since
  /// the last one. In virtual time only the heartbeats of the Stop road (stop_line.h) are judged by
  /// it. Cost: that of the scene, and about 1 us.
  HD_REALTIME void tick_once(std::int64_t now_ns, std::uint64_t skipped = 0) noexcept;

  /// Obeys what waits in the channels, as every tick does first. Between ticks of virtual time,
  /// which may stand still for long; a scene is then exchanged at once.
  HD_REALTIME void take_commands() noexcept;

  /// The tick that `recorded` was, with devices that are all replayed ones: their samples, commands
  /// and time as recorded, whatever waits in the channels. Give scenes and changes before.
  void replay_once(const Tick& recorded) noexcept;
  /// The scene of the next tick of a replay.
  void replace_scene(std::unique_ptr<PlayedScene> scene) noexcept;
  /// Its ramp begins with the next tick of a replay. False when it is for another scene.
  bool replay_change(std::unique_ptr<SettingsChange> change) noexcept;

  /// All that goes from tick to tick, between two ticks; false when it is too much for a snapshot.
  /// Cost: a copy of each number.
  [[nodiscard]] HD_REALTIME bool fill_snapshot(Snapshot& snapshot) const noexcept;
  /// Goes on from `snapshot`, which may come from a file, in the scene that plays. False when it
  /// does not fit; the loop is of no use then.
  [[nodiscard]] bool restore(const Snapshot& snapshot);

  /// The guardian's look at the loop, from its own thread: writes zero to the devices of a loop
  /// that stands still.
  void guard(std::int64_t now_ns) noexcept { guard_.look(now_ns); }

  /// True once the force has ramped out after an EndCommand.
  [[nodiscard]] bool over() const noexcept { return kept_.machine.state == LoopState::kOver; }

  /// Tick that runs next. Loop's thread.
  [[nodiscard]] std::uint64_t next_tick() const noexcept { return kept_.time.tick; }

  /// What plays. Loop's thread.
  [[nodiscard]] PlayedScene& scene() noexcept { return scenes_.playing(); }

 private:
  /// What is wrong in a tick, and with which tool.
  struct Fault {
    Cause cause = Cause::kNone;
    std::size_t tool = 0;
  };

  void obey(const LoopCommand& command) noexcept;
  void obey_tool(const LoopCommandBody& what) noexcept;
  [[nodiscard]] std::optional<Cause> refusal_of(const LoopCommandBody& what) const noexcept;
  void mend_devices() noexcept;
  void start_anew() noexcept;
  void lose_lease(const LeaseLostCommand& lost) noexcept;
  /// What is queued for devices that follow poses; false when there are none.
  bool forget_poses() noexcept;
  void gather_orders(std::int64_t now_ns) noexcept;
  void pass(std::int64_t now_ns, std::uint64_t skipped) noexcept;
  void begin_time(std::int64_t now_ns, std::uint64_t skipped) noexcept;
  void take_scene(std::unique_ptr<PlayedScene> scene, std::uint64_t number) noexcept;
  void swap_scene() noexcept;
  void begin_scene() noexcept;
  void give_back_scene() noexcept;
  void play_gesture(std::unique_ptr<GesturePlan> plan, std::uint64_t number) noexcept;
  void take_change(std::unique_ptr<SettingsChange> change, std::uint64_t number) noexcept;
  void report_late(std::uint64_t skipped) noexcept;
  void read_devices() noexcept;
  [[nodiscard]] Fault find_fault() const noexcept;
  void advance_state() noexcept;
  void forget_rendered() noexcept;
  void render() noexcept;
  void limit_wrenches() noexcept;
  void write_devices() noexcept;
  void tell() noexcept;
  void publish_snapshot() noexcept;
  [[nodiscard]] std::size_t tool_count() const noexcept { return scenes_.playing().tools.size(); }
  [[nodiscard]] std::span<ToolLoop> tools() noexcept { return {kept_.tools.data(), tool_count()}; }
  [[nodiscard]] std::span<const ToolLoop> tools() const noexcept {
    return {kept_.tools.data(), tool_count()};
  }
  [[nodiscard]] bool all_have_poses() const noexcept;
  /// Nothing touched or pushed a tool in the last tick rendered.
  [[nodiscard]] bool contact_free() const noexcept;
  /// All tools have been rendered: contact_free() means something.
  [[nodiscard]] bool contact_known() const noexcept;
  /// The simulation computed what is no number in the last tick.
  [[nodiscard]] bool numbers_lost() const noexcept;
  /// A tool lost its way (tool_loop.h).
  [[nodiscard]] bool far_off() const noexcept;
  /// Null in virtual time, in which nothing is told of times.
  [[nodiscard]] StageClock* stage_clock() noexcept {
    return options_.virtual_time ? nullptr : &clock_;
  }

  /// Before every instant: a snapshot is due at once.
  static constexpr std::int64_t kNow = std::numeric_limits<std::int64_t>::min();

  LoopOptions options_;
  LoopChannels& channels_;
  SceneSlot scenes_;
  LoopMemory kept_;
  Orders orders_;
  StallGuard guard_;
  Publisher publisher_{channels_, kept_.time, scenes_};

  Tick tick_;  ///< under way, as it will be told
  LoopOutput loop_output_;
  StageClock clock_{monotonic_now_ns};
  bool late_ = false;  ///< more late ticks of late than are put up with

  Cause standing_fault_ = Cause::kNone;  ///< in the last tick
  std::uint64_t late_skipped_ = 0;       ///< periods, not yet logged
  std::int64_t late_told_ns_ = 0;
  std::int64_t cpu_before_ns_ = 0;
  std::int64_t snapshot_due_ns_ = kNow;
  std::uint64_t events_overflow_ = 0;
};

}  // namespace hapticd
