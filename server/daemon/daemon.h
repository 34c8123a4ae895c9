// hapticd itself: makes the desks and joins them with the haptic loop and the network. Everything
// here runs on the network thread, which is the main one; the loop has its own thread under the
// real clock, and is stepped from here under the virtual one. Not RT.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "server/daemon/asset_desk.h"
#include "server/daemon/catalogues.h"
#include "server/daemon/daemon_plan.h"
#include "server/daemon/daemon_time.h"
#include "server/daemon/device_desk.h"
#include "server/daemon/key_watch.h"
#include "server/daemon/loop_desk.h"
#include "server/daemon/play_desk.h"
#include "server/daemon/quality_desk.h"
#include "server/daemon/record_desk.h"
#include "server/daemon/request_table.h"
#include "server/daemon/scene_desk.h"
#include "server/daemon/served_clients.h"
#include "server/daemon/service_desk.h"
#include "server/daemon/state_desk.h"
#include "server/daemon/stop_opening.h"
#include "server/network/lease_report.h"
#include "server/network/loss_report.h"
#include "server/network/protocol_server.h"
#include "server/network/udp_transport.h"
#include "server/recorder/recorder_thread.h"

namespace hapticd {

/// What signals ask for: set by their handlers, read by Daemon.
struct SignalRequests {
  std::atomic<bool> end{false};     ///< SIGTERM, SIGINT
  std::atomic<bool> reload{false};  ///< SIGHUP
};

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
  /// What plays: devices, or a recording and its own plan.
  struct Opened {
    DaemonPlan plan;
    std::unique_ptr<ReplayRun> replay;  ///< null: devices
  };

  explicit Daemon(Opened opened);
  [[nodiscard]] static Opened open(DaemonOptions options);
  [[nodiscard]] std::unique_ptr<RecorderThread> make_recorder();
  void begin_loop(const ReplayRun* replay);
  void begin_time(std::unique_ptr<ReplayRun> replay);
  void begin_serving();
  void bind();
  [[nodiscard]] ServerHost make_host();
  void read_keys();
  void follow_keys(std::int64_t now_ns);

  bool work(std::int64_t now_ns);
  void follow_signals(SignalRequests& signals, std::int64_t now_ns);
  void end(const char* why, std::int64_t now_ns);
  void take_event(const LoopEvent& event);
  void tell_clients(const LoopEvent& event);
  void take_ticks(std::int64_t now_ns);
  void add_to_hash();
  void start_time();
  void report_start() const;
  [[nodiscard]] bool replays() const { return recorder_ == nullptr; }

  DaemonPlan plan_;
  bool stepped_here_;  ///< the loop has no thread of its own
  ServedClients clients_;
  DeviceDesk devices_;  ///< they outlive the loop
  LoopDesk loop_;
  std::unique_ptr<RecorderThread> recorder_;  ///< null: a replay is not recorded
  AssetDesk assets_;
  SceneDesk scenes_;
  PlayDesk play_;
  RecordDesk records_;
  QualityDesk quality_;
  StateDesk states_;
  ServiceDesk service_;
  std::optional<KeyWatch> keys_;         ///< none: PLAIN sessions
  bool keys_changed_ = false;            ///< and the server does not know yet
  Catalogues catalogues_;                ///< of scenes, gestures and recordings
  std::unique_ptr<StopRoad> stop_road_;  ///< null: off, or a replay
  std::optional<DaemonTime> time_;
  std::optional<RequestTable> requests_;
  std::unique_ptr<UdpTransport> transport_;
  std::unique_ptr<ProtocolServer> server_;
  LossReport losses_;
  LeaseReport leases_;
  std::int64_t ending_since_ns_ = -1;
};

}  // namespace hapticd
