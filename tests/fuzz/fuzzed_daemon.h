// hapticd with its real desks, loop, server and one client, without sockets, devices or a clock of
// its own: what fuzz targets give requests to. Not RT.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "clients/library/client_core.h"
#include "server/daemon/quality_desk.h"
#include "server/daemon/request_table.h"
#include "server/daemon/state_desk.h"
#include "server/network/protocol_server.h"
#include "tests/fuzz/loop_judge.h"

namespace hapticd::test {

/// Plays a scene of two tools, number 3 in a simulated hand and 7 in that of a client.
class FuzzedDaemon {
 public:
  /// Under the virtual clock ticks pass by Runs alone, else one with each pass().
  explicit FuzzedDaemon(bool virtual_clock);
  FuzzedDaemon(const FuzzedDaemon&) = delete;
  FuzzedDaemon& operator=(const FuzzedDaemon&) = delete;
  ~FuzzedDaemon();

  /// The client asks, having taken the lease if nobody has it, and waits until all that can be has
  /// been answered; whether the answer was good. Throws std::logic_error where an answer or what
  /// reaches the loop is what it must not be.
  bool ask(const v1::Item& request);
  /// A millisecond in which everybody does what there is to do.
  void pass();
  /// The client leaves, and is forgotten with all that it had asked for.
  void end();

 private:
  using Datagram = std::vector<std::uint8_t>;

  [[nodiscard]] LoopOptions loop_options() const;
  [[nodiscard]] ServerHost host();
  void begin_time();
  void acquire();
  void request(const v1::Item& item);
  void take_result(const v1::Result& result);
  void take_event(const LoopEvent& event);
  void take_ticks();
  void judge();
  void work();

  DaemonPlan plan_;
  ServedClients clients_;
  DeviceDesk devices_;
  LoopDesk loop_;
  RecorderThread recorder_;
  AssetDesk assets_;
  SceneDesk scenes_;
  PlayDesk play_;
  RecordDesk records_;
  QualityDesk quality_;
  StateDesk states_;
  Catalogues catalogues_;
  std::optional<DaemonTime> time_;
  std::optional<RequestTable> requests_;
  std::optional<ProtocolServer> server_;
  std::optional<client::ClientCore> client_;
  LoopJudge judge_;
  std::deque<Datagram> to_server_;
  std::deque<Datagram> to_client_;
  std::int64_t now_ns_ = 1'000'000'000;
  int waiting_ = 0;    ///< requests without an answer
  bool good_ = false;  ///< the newest answer
};

}  // namespace hapticd::test
