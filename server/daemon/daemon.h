// hapticd itself: joins the haptic loop with sessions, scenes and gestures. Everything here runs on
// the network thread, which is the main one; the loop has its own thread under the real clock, and
// is stepped from here under the virtual one. Not RT.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/daemon/catalogues.h"
#include "server/daemon/daemon_options.h"
#include "server/daemon/force_watch.h"
#include "server/daemon/quality_governor.h"
#include "server/daemon/replay_run.h"
#include "server/daemon/scene_player.h"
#include "server/daemon/tick_statistics.h"
#include "server/daemon/work_cost.h"
#include "server/devices/outside_device.h"
#include "server/encoding/encode_event.h"
#include "server/encoding/state_hash.h"
#include "server/haptic_loop/realtime_thread.h"
#include "server/network/protocol_server.h"
#include "server/network/udp_transport.h"
#include "server/recorder/recording.h"

namespace hapticd {

/// What signals ask for; set by handlers, looked at by Daemon.
struct SignalRequests {
  std::atomic<bool> end{false};     ///< SIGTERM, SIGINT
  std::atomic<bool> reload{false};  ///< SIGHUP
};

/// The recording that `options` name as their device, and its configuration in place of theirs;
/// null when they name none. Throws StartError.
[[nodiscard]] std::unique_ptr<ReplayRun> open_replay(DaemonOptions& options);

/// How scenes were played when `header` was recorded. Throws StartError.
[[nodiscard]] PlayerOptions recorded_player(const v1::RecordHeader& header);

// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): there is one
class Daemon {
 public:
  /// Loads everything and binds the socket. Throws StartError.
  explicit Daemon(DaemonOptions options);
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;
  ~Daemon();

  /// Plays until a signal asks for the end; returns the exit code. Throws StartError when realtime
  /// is required and refused.
  int run(SignalRequests& signals);

 private:
  /// A scene that plays, or is about to.
  struct LiveScene {
    std::uint32_t id = 0;
    std::shared_ptr<const LoadedScene> loaded;
    SceneIndex index;
    v1::SceneInfo info;  ///< as of now; no longer for what is set live, but for a few knobs
    /// With the parameters as they are set now, ramps as if ended; knobs that quality decides are
    /// left open.
    v1::Scene live;
    v1::Quality choice;      ///< of the scene, or of clients since; --quality may stand above it
    SceneSettings settings;  ///< that follow from `live`, at the level that plays

    struct Parameters {
      v1::Scene live;
      v1::Quality choice;
      SceneSettings settings;
    };
    /// A change that the loop has been lent.
    struct Change {
      const SettingsChange* lent = nullptr;
      std::uint64_t at_tick = 0;  ///< it begins then, or soon after
      Parameters parameters;      ///< after it
    };
    std::deque<Change> changes;  ///< not over yet, as they were asked for
    Parameters in_force;         ///< after the last one that is over

    /// They are what is set now, and told.
    void take(Parameters now);
  };
  /// A scene being built off-thread for a request, or for SIGHUP.
  struct SceneBuild {
    std::optional<RequestId> request;
    bool check_only = false;
    std::future<LoadResult> result;
  };
  /// A Run of steps under way.
  struct StepRun {
    RequestId request;
    std::uint64_t wanted = 0;
    std::uint64_t done = 0;
    std::uint64_t held_before = 0;
  };
  /// A push that the loop was asked for.
  struct AskedPush {
    std::uint64_t number = 0;  ///< of the command
    DeviceCheck* check = nullptr;
    PushAxis axis = 0;
  };
  /// A step of a device's own calibration, until the device has answered.
  struct AskedCalibration {
    RequestId request;
    DeviceCalibration* calibration = nullptr;
  };
  /// A request for parameters that waits for the loop to have heard of a lost lease.
  struct HeldRequest {
    RequestId id;
    v1::Item item;
    std::uint64_t lease_ends = 0;  ///< when it came
  };
  enum class TimeMode : std::uint8_t { kStopped, kLive };

  // Start and run (daemon.cpp).
  [[nodiscard]] std::unique_ptr<PlayedScene> first_scene();
  [[nodiscard]] ServerHost make_host();
  bool work(std::int64_t now_ns);
  void follow_signals(SignalRequests& signals, std::int64_t now_ns);
  void take_events();
  void take_event(const LoopEvent& event);
  void tell_clients(const LoopEvent& event);
  void finish_command(std::uint64_t number, bool obeyed, Cause cause);
  void take_snapshots(std::int64_t now_ns);
  void tell_lease_ends();
  void report_start() const;

  // Configuration read anew (daemon_reload.cpp).
  void reload();
  void reload_scene();

  // Work that is bounded, and quality that follows a budget (daemon_quality.cpp).
  [[nodiscard]] QualityWish quality_wish() const;
  /// What is in force at a tick that is near.
  [[nodiscard]] static const v1::Quality& quality_at(const LiveScene& scene, std::uint64_t tick);
  void follow_budget(const Snapshot& snapshot);
  void forget_prices();
  [[nodiscard]] PricedTick tick_before(const Snapshot& snapshot);
  void allow_work(std::int64_t work);
  void follow_level(const Snapshot& snapshot, std::int64_t cost_ns, double budget_us);
  void explain_quality(const Snapshot& snapshot, v1::State& state) const;
  void report_budget() const;

  // Scenes (daemon_scenes.cpp).
  [[nodiscard]] LoadOptions load_options() const;
  [[nodiscard]] bool simulates() const;
  LiveScene& begin_playing(std::shared_ptr<const LoadedScene> loaded);
  [[nodiscard]] std::unique_ptr<GesturePlan> first_gesture(const LoadedScene& scene) const;
  void build_scene(std::optional<RequestId> request, const v1::LoadScene& load);
  void finish_build();
  void swap_to(std::shared_ptr<const LoadedScene> loaded, std::unique_ptr<PlayedScene> played,
               std::optional<RequestId> request);
  void finish_swap(std::uint32_t scene_id);
  [[nodiscard]] const LiveScene& playing(std::uint32_t scene_id) const;

  // Requests (daemon_requests.cpp), those for parameters (daemon_parameters.cpp).
  void request(const RequestId& id, const v1::Item& item);
  /// True: it is held until the changes of a lost lease are gone.
  [[nodiscard]] bool hold(const RequestId& id, const v1::Item& item);
  void carry_out_held();
  /// False, and answered BUSY, when the loop's ring is full; what `what` points to stays ours then.
  bool command(const RequestId& id, const LoopCommandBody& what);
  void load_scene_for(const RequestId& id, const v1::LoadScene& load);
  void get_parameters(const RequestId& id, const v1::GetParameters& get);
  void set_parameters(const RequestId& id, const v1::SetParameter& set);
  /// The loop gives `change` back; `dropped`: it never began, and what it set is unset.
  void settle_change(const SettingsChange& change, bool dropped);
  [[nodiscard]] std::optional<v1::Result> fault_of_pose(const v1::PoseSample& sample,
                                                        const std::string& path) const;
  void queue_poses(const RequestId& id, const v1::PoseBatch& batch);
  void play_gesture(const RequestId& id, const v1::PlayGesture& play);
  void list(const RequestId& id, const std::vector<ListedName>& names);
  void describe_devices(const RequestId& id);

  // Recording (daemon_records.cpp).
  [[nodiscard]] v1::RecordHeader record_header() const;
  /// Begins what --record asks for: before the first tick, which a replay begins with. Throws
  /// StartError.
  void begin_recording();
  /// Removes it: hapticd does not start after all.
  void take_back_recording();
  void announce_scene(const LiveScene& scene);
  void announce_change(const SceneSettings& settings, const v1::SetParameter* set);
  void record(const RequestId& id, const v1::Record& record);
  void record_event(const LoopEvent& event, const v1::Item& item);
  void report_recording();

  // Replay (daemon_replay.cpp).
  [[nodiscard]] std::unique_ptr<PlayedScene> make_recorded_scene(const v1::SceneRecord& record);
  void begin_replay();
  bool pass_replay(std::int64_t now_ns);
  void end_replay(std::int64_t now_ns);
  void fill_replay(v1::State& state) const;
  [[nodiscard]] bool refuse_in_replay(const RequestId& id, const v1::Item& item);
  void answer_replay(const RequestId& id, const v1::Replay& replay);

  // Time (daemon_time.cpp).
  void run_time(const RequestId& id, const v1::Run& run);
  bool pass_virtual_time(std::int64_t now_ns);
  void step_once(std::int64_t now_ns);
  void end_steps(v1::ResultCode code);

  // Devices outside the process (daemon_devices.cpp).
  void attach_devices();
  [[nodiscard]] PaceSource pace_source() const;
  [[nodiscard]] v1::DeviceInfo device_info(std::size_t k) const;
  void watch_forces(const Snapshot& snapshot);
  /// Null: that of the tool is inside the process.
  [[nodiscard]] const OutsideDevice* outside_of(std::uint32_t tool_id) const;

  // Their guided check and calibration (daemon_checks.cpp).
  void calibrate(const RequestId& id, const v1::Calibrate& calibrate);
  [[nodiscard]] v1::Result begin_calibration(const RequestId& id, const OutsideDevice& outside,
                                             v1::CalibrateStep step);
  void push(const RequestId& id, const v1::Calibrate& calibrate, const OutsideDevice& outside);
  void note_push(std::uint64_t number, std::int64_t t_ns);
  void note_no_force(const Snapshot& snapshot);
  void finish_calibrations();

  DaemonOptions options_;
  std::unique_ptr<ReplayRun> replay_;  ///< null: devices play
  PlayerOptions player_;
  std::vector<OutsideDevice> outside_;  ///< devices outside the process; they outlive the loop
  bool virtual_time_;                   ///< the loop is stepped from here
  std::unique_ptr<LoopChannels> channels_;
  std::unique_ptr<Recording> recording_;  ///< null: a replay is not recorded
  std::unique_ptr<HapticLoop> loop_;
  std::unique_ptr<RealtimeThread> thread_;
  std::unique_ptr<UdpTransport> transport_;
  std::unique_ptr<ProtocolServer> server_;

  /// The one that plays; before it the last one, until its snapshots are all taken; after it the
  /// next one, until it plays.
  std::deque<LiveScene> scenes_;
  Catalogues catalogues_;         ///< of scenes, gestures and recordings
  std::uint32_t playing_id_ = 0;  ///< of the one that clients know of; 0: none yet
  std::uint32_t last_scene_id_ = 0;
  RecordStatus told_record_;  ///< what clients were told last
  std::uint64_t fault_dumps_ = 0;
  std::optional<SceneBuild> build_;
  std::deque<std::pair<std::uint64_t, RequestId>> commands_;  ///< not yet obeyed, by number
  std::uint64_t last_command_ = 0;
  std::optional<AskedPush> push_;  ///< the last one, until the loop has begun it
  std::vector<AskedCalibration> calibrations_;
  const Snapshot* snapshot_ = nullptr;  ///< being offered
  LoopState newest_state_ = LoopState::kDetached;
  std::uint64_t newest_tick_ = 0;
  TickStatistics statistics_;
  StateHash hash_;
  std::array<std::uint64_t, kMaxTools> next_pose_ticks_{};  ///< of each tool
  std::uint64_t lease_ends_ = 0;                            ///< leases that have ended
  std::uint64_t told_lease_ends_ = 0;    ///< of them those that the loop has been told of
  std::uint64_t lease_end_command_ = 0;  ///< that told it, and is not obeyed yet; 0: none
  std::deque<HeldRequest> held_;
  TimeMode mode_ = TimeMode::kStopped;
  std::optional<StepRun> steps_;
  bool stop_asked_ = false;  ///< during a Run of steps, and not obeyed yet
  std::int64_t live_due_ns_ = 0;
  std::int64_t ending_since_ns_ = -1;
  bool end_requested_ = false;  ///< of a replay, by a client
  int exit_code_ = kExitGood;
  /// The tick before the newest snapshot: its time is told with the next.
  struct TickBefore {
    std::uint64_t next_tick = 0;
    std::uint64_t overruns = 0;
    std::uint64_t work = 0;
  };
  QualityGovernor governor_;  ///< of automatic quality
  WorkCost price_;            ///< of this machine, under the real clock
  std::optional<TickBefore> before_;
  std::uint32_t governed_scene_ = 0;
  std::int64_t allowed_work_ = 0;  ///< that the loop was told last, or began with; 0: no bound
  std::uint64_t change_tick_ = 0;  ///< of the last change of parameters
  bool reload_waits_ = false;      ///< the scene is to be loaded anew, once nothing else is
  bool swapping_ = false;          ///< a scene waits for the loop to take it
  ForceWatch force_watch_;
  std::array<double, kMaxTools> stiffness_bounds_{};  ///< granted, N/m
  std::array<double, kMaxTools> measured_delays_{};   ///< by drivers, s; NaN or 0: not measured
};

}  // namespace hapticd
