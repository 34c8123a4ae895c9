// The haptic loop without its clock: one call of tick_once() reads the devices, advances the loop's
// state, steps the simulation, passes each tool's wrench through the safety stage, writes it, and
// tells the other threads. One state for all tools: they get force together, and the fault of one
// takes it from all. run_realtime() (realtime_thread.h) calls it on time; lockstep and tests call
// it as they like. Links no network, protobuf or log. RT: yes but for construction.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "core/rt/monotonic_clock.h"
#include "core/rt/owner_ring.h"
#include "core/rt/rt_log.h"
#include "core/rt/spsc_ring.h"
#include "core/safety/guardian.h"
#include "core/safety/overrun_watch.h"
#include "core/simulation/simulation.h"
#include "core/tick/tick_ring.h"
#include "server/haptic_loop/loop_command.h"
#include "server/haptic_loop/loop_event.h"
#include "server/haptic_loop/played_scene.h"
#include "server/haptic_loop/settings_change.h"
#include "server/haptic_loop/snapshot.h"
#include "server/haptic_loop/tool_loop.h"

namespace hapticd {

/// Commands obeyed in one tick, at most; the others wait. A few, so that no sender can lengthen a
/// tick.
inline constexpr int kCommandsPerTick = 8;

/// Changes of settings that wait for their tick, at most; further ones are refused.
inline constexpr std::size_t kWaitingChanges = 64;

/// Poses taken over in one tick, at most; a sender of one per tick is never waited for.
inline constexpr int kPosesPerTick = 64;

/// A pose for a tick, of a device that follows poses.
struct TickPose {
  std::uint64_t tick = 0;
  std::uint32_t tool = 0;   ///< in the scene's order
  std::uint64_t lease = 0;  ///< how many leases had ended when it was given
  QueuedPose pose;
};

/// Ticks on their way to the network: half a second of usual ones at 1 kHz, 13 of the fullest.
using NetworkTicks = TickRing<3U << 19U>;
/// Ticks on their way to the recorder: 4 s of usual ones, 70 of the fullest.
using RecorderTicks = TickRing<8U << 20U>;

/// What is lent to the loop and given back: two rings. No more than `Capacity` things may be with
/// the loop at a time, or on their way.
template <typename T, std::size_t Capacity>
struct Lending {
  OwnerRing<std::unique_ptr<T>, Capacity> lent;  ///< to the loop; each before its command
  OwnerRing<std::unique_ptr<T>, Capacity> back;  ///< not touched any more, to be freed
};

/// What the loop exchanges with the network thread. One writer and one reader each.
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
};

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
  ~HapticLoop();

  /// One tick at `now_ns` (ignored in virtual time), `skipped` periods having been passed over
  /// since the last one. Cost: that of the scene, and about 1 us.
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
  void guard(std::int64_t now_ns) noexcept;

  /// True once the force has ramped out after an EndCommand.
  [[nodiscard]] bool over() const noexcept { return machine_.state == LoopState::kOver; }

  /// Tick that runs next. Loop's thread.
  [[nodiscard]] std::uint64_t next_tick() const noexcept { return time_.tick; }

  /// What plays. Loop's thread.
  [[nodiscard]] PlayedScene& scene() noexcept { return *scene_; }

 private:
  void obey(const LoopCommand& command) noexcept;
  [[nodiscard]] std::optional<Cause> refusal_of(const LoopCommandBody& what) const noexcept;
  void mend_devices() noexcept;
  void lose_lease(const LeaseLostCommand& lost) noexcept;
  void clear_devices() noexcept;
  void gather_orders() noexcept;
  void pass(std::int64_t now_ns, std::uint64_t skipped) noexcept;
  void take_scene(std::unique_ptr<PlayedScene> scene, std::uint64_t number) noexcept;
  void swap_scene() noexcept;
  void begin_scene() noexcept;
  void give_back_scene() noexcept;
  [[nodiscard]] bool begin_gesture(const GesturePlan& plan) noexcept;
  void play_gesture(std::unique_ptr<GesturePlan> plan, std::uint64_t number) noexcept;
  void take_change(std::unique_ptr<SettingsChange> change, std::uint64_t number) noexcept;
  void retire(std::unique_ptr<SettingsChange> change, bool dropped = false) noexcept;
  void follow_changes() noexcept;
  void report_late(std::uint64_t skipped) noexcept;
  void read_devices() noexcept;
  void blame(Cause cause, std::size_t tool) noexcept;
  void find_faults() noexcept;
  void advance_state() noexcept;
  void render() noexcept;
  void limit_wrenches() noexcept;
  void write_devices() noexcept;
  void report_events() noexcept;
  void publish_snapshot() noexcept;
  void restore_tool(std::size_t k, SnapshotReader& read);
  void restore_strings(SnapshotReader& read);
  void publish_tick() noexcept;
  void fill_head() noexcept;
  void fill_tool(std::size_t k, ToolTick& told) const noexcept;
  void fill_contacts() noexcept;
  void fill_strings() noexcept;
  template <typename What>
  void tell(const What& what, std::size_t tool = 0) noexcept;
  [[nodiscard]] std::size_t tool_count() const noexcept { return scene_->tools.size(); }
  [[nodiscard]] std::span<ToolLoop> tools() noexcept { return {tools_.data(), tool_count()}; }
  [[nodiscard]] bool all_have_poses() const noexcept;
  /// Null in virtual time, in which nothing is told of times.
  [[nodiscard]] StageClock* stage_clock() noexcept {
    return options_.virtual_time ? nullptr : &clock_;
  }
  /// Nothing touched or pushed a tool in the last tick rendered.
  [[nodiscard]] bool contact_free() const noexcept;

  /// Before every instant: a snapshot is due at once.
  static constexpr std::int64_t kNow = std::numeric_limits<std::int64_t>::min();

  LoopOptions options_;
  LoopChannels& channels_;
  std::unique_ptr<PlayedScene> scene_;
  std::unique_ptr<PlayedScene> waiting_;  ///< takes the place of scene_ once it may
  std::unique_ptr<PlayedScene> retired_;  ///< to be given back once the guardian is not at it
  std::uint64_t waiting_number_ = 0;
  std::unique_ptr<SettingsChange> change_;  ///< its ramp is under way
  double change_share_ = 0.0;
  /// For later ticks, as they came; the first `waiting_changes_`.
  std::array<std::unique_ptr<SettingsChange>, kWaitingChanges> changes_;
  std::size_t waiting_changes_ = 0;
  std::array<std::atomic<HapticDevice*>, kMaxTools> guarded_{};
  std::atomic<std::int64_t> heartbeat_ns_{0};
  std::atomic<bool> guarding_{false};  ///< the guardian is writing to one of guarded_
  std::atomic<bool> force_on_{false};
  std::atomic<std::uint64_t> stalls_{0};
  Guardian guardian_;  ///< of the guardian's thread
  std::uint64_t stalls_seen_ = 0;

  // Of the tick under way.
  LoopTime time_;
  LoopInput loop_input_;
  LoopOutput loop_output_;
  std::uint16_t orders_ = 0;        ///< OrderBit
  std::uint64_t skipped_ = 0;       ///< periods before this tick
  std::uint64_t begun_change_ = 0;  ///< number; 0: none
  std::size_t blamed_ = 0;          ///< tool that loop_input_.fault is of

  // From tick to tick.
  LoopMachine machine_;
  OverrunWatch overrun_watch_;
  std::array<ToolLoop, kMaxTools> tools_;  ///< the first tool_count()
  Cause standing_fault_ = Cause::kNone;    ///< in the last tick
  TimesTick times_;
  StageClock clock_{monotonic_now_ns};
  std::uint64_t late_skipped_ = 0;  ///< periods, not yet logged
  std::int64_t late_told_ns_ = 0;
  std::int64_t cpu_before_ns_ = 0;
  std::int64_t work_budget_ = 0;  ///< of a tick; 0: no bound
  std::uint64_t leases_ended_ = 0;
  unsigned asked_ = 0;  ///< OrderBit, by commands since the last tick
  std::int64_t snapshot_due_ns_ = kNow;
  std::int64_t clear_until_ns_ = kNow;  ///< a Clear waits for a device to forget its fault
  bool first_tick_ = true;
  bool ever_ticked_ = false;
  bool lease_lost_ = false;
  bool late_ = false;  ///< more late ticks of late than are put up with
  std::uint64_t events_overflow_ = 0;
  TickOutput output_;
  Tick tick_;  ///< as it is told
  TouchEvents touch_events_;
};

}  // namespace hapticd
