// The Stop road: a socket and a thread of its own, by which a Stop reaches the loop whatever the
// network's thread does. The thread shares no lock with any other, uses no heap, and makes these
// system calls alone: ppoll, recvmmsg, sendmsg, clock_nanosleep; at its beginning prctl, for its
// name. SCHED_FIFO one below the loop where the machine grants it; of each millisecond it takes
// what 128 datagrams need, 0.2 ms, so that a flood delays nothing but the road. Not RT.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "proto/stop/stop_counters.h"
#include "server/haptic_loop/stop_line.h"
#include "server/stop_road/stop_judge.h"
#include "server/stop_road/stop_socket.h"

namespace hapticd {

/// Where the road is to be, and who is heard.
struct StopRoadOptions {
  std::string host = "127.0.0.1";
  std::uint16_t port = stop::kDefaultPort;
  bool elsewhere = false;  ///< where the port is taken another one will do
  StopRules rules;
};

class StopRoad {
 public:
  /// Binds. Throws as StopSocket does. `line` must outlive this.
  StopRoad(const StopRoadOptions& options, StopLine& line);
  ~StopRoad();
  StopRoad(const StopRoad&) = delete;
  StopRoad& operator=(const StopRoad&) = delete;

  /// Hears from here on.
  void start();

  [[nodiscard]] std::string local_address() const { return socket_.local_address(); }
  [[nodiscard]] std::uint16_t port() const noexcept { return socket_.port(); }
  /// Any thread.
  [[nodiscard]] const StopCounters& counters() const noexcept { return judge_.counters(); }

 private:
  /// What may be taken until the next millisecond.
  struct Turn {
    std::int64_t begun_ns = 0;
    int reads = 0;
    int answers = 0;
  };

  void run() noexcept;
  void take() noexcept;

  StopSocket socket_;
  StopJudge judge_;
  Turn turn_;  ///< of the thread
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

}  // namespace hapticd
