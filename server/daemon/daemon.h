// hapticd itself: makes the desks and joins them with the haptic loop and the network. Everything
// here runs on the network thread, which is the main one; the loop has its own thread under the
// real clock, and is stepped from here under the virtual one. Not RT.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "server/daemon/catalogues.h"
#include "server/daemon/daemon_plan.h"
#include "server/daemon/daemon_time.h"
#include "server/daemon/force_watch.h"
#include "server/daemon/loop_desk.h"
#include "server/daemon/play_desk.h"
#include "server/daemon/quality_desk.h"
#include "server/daemon/record_desk.h"
#include "server/daemon/request_table.h"
#include "server/daemon/scene_desk.h"
#include "server/daemon/served_clients.h"
#include "server/daemon/state_desk.h"
#include "server/devices/outside_device.h"
#include "server/network/protocol_server.h"
#include "server/network/udp_transport.h"
#include "server/recorder/recording.h"

namespace hapticd {

/// What signals ask for; set by handlers, looked at by Daemon.
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

  explicit Daemon(Opened opened);
  [[nodiscard]] static Opened open(DaemonOptions options);
  [[nodiscard]] std::unique_ptr<Recording> make_recording();
  void begin_loop(const ReplayRun* replay);
  void begin_time(std::unique_ptr<ReplayRun> replay);
  void begin_serving();
  [[nodiscard]] ServerHost make_host();

  bool work(std::int64_t now_ns);
  void follow_signals(SignalRequests& signals, std::int64_t now_ns);
  void end(const char* why, std::int64_t now_ns);
  void take_event(const LoopEvent& event);
  void tell_clients(const LoopEvent& event);
  void take_snapshots(std::int64_t now_ns);
  void start_time();
  void report_start() const;
  [[nodiscard]] bool replays() const { return recording_ == nullptr; }

  // Devices outside the process (daemon_devices.cpp).
  void attach_devices();
  [[nodiscard]] PaceSource pace_source() const;
  [[nodiscard]] v1::DeviceInfo device_info(std::size_t k) const;
  void watch_forces(const Snapshot& snapshot);
  /// Null: that of the tool is inside the process.
  [[nodiscard]] const OutsideDevice* outside_of(std::uint32_t tool_id) const;
  [[nodiscard]] Answer describe_devices() const;

  // Their guided check and calibration (daemon_checks.cpp).
  [[nodiscard]] Answer calibrate(const RequestId& id, const v1::Calibrate& calibrate);
  [[nodiscard]] Answer begin_calibration(const RequestId& id, const OutsideDevice& outside,
                                         v1::CalibrateStep step);
  [[nodiscard]] Answer push(const RequestId& id, const v1::Calibrate& calibrate,
                            const OutsideDevice& outside);
  void note_push(const LoopEvent& event);
  void note_no_force(const Snapshot& snapshot);
  void finish_calibrations();

  DaemonPlan plan_;
  bool stepped_here_;                   ///< the loop has no thread of its own
  std::vector<OutsideDevice> outside_;  ///< devices outside the process; they outlive the loop
  ServedClients clients_;
  LoopDesk loop_;
  std::unique_ptr<Recording> recording_;  ///< null: a replay is not recorded
  SceneDesk scenes_;
  PlayDesk play_;
  RecordDesk records_;
  QualityDesk quality_;
  StateDesk states_;
  Catalogues catalogues_;  ///< of scenes, gestures and recordings
  std::optional<DaemonTime> time_;
  std::optional<RequestTable> requests_;
  std::unique_ptr<UdpTransport> transport_;
  std::unique_ptr<ProtocolServer> server_;
  std::int64_t ending_since_ns_ = -1;

  std::optional<AskedPush> push_;  ///< the last one, until the loop has begun it
  std::vector<AskedCalibration> calibrations_;
  ForceWatch force_watch_;
  std::array<double, kMaxTools> stiffness_bounds_{};  ///< granted, N/m
  std::array<double, kMaxTools> measured_delays_{};   ///< by drivers, s; NaN or 0: not measured
};

}  // namespace hapticd
