// Time of a recording that is played again: it takes the place of devices, clients and clock. See
// replay_run.h. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "hapticd/v1/state.pb.h"
#include "server/daemon/daemon_options.h"
#include "server/daemon/loop_desk.h"
#include "server/daemon/replay_run.h"
#include "server/daemon/scene_desk.h"

namespace hapticd {

/// The recording that `options` name as their device, and its configuration in place of theirs;
/// null when they name none. Throws StartError.
[[nodiscard]] std::unique_ptr<ReplayRun> open_replay(DaemonOptions& options);

class ReplayTime {
 public:
  /// All outlive this.
  struct Parts {
    LoopDesk& loop;
    SceneDesk& scenes;
    ServedClients& clients;
    std::function<void(std::int64_t)> hand_on;  ///< a tick is over: takes what it told
  };

  /// The loop plays the first scene of `run`, and has had no tick yet. Throws StartError when the
  /// recording cannot be begun.
  ReplayTime(const Parts& parts, std::unique_ptr<ReplayRun> run, const v1::Config& config);
  ReplayTime(const ReplayTime&) = delete;
  ReplayTime& operator=(const ReplayTime&) = delete;

  void start() noexcept {}
  /// Some of the ticks that are due; true: more are.
  bool pass(std::int64_t now_ns);
  /// Ticks pass only here.
  [[nodiscard]] bool over() const noexcept { return true; }

  /// Ends it at the next look, for a client.
  void ask_for_end() noexcept { end_asked_ = true; }
  [[nodiscard]] bool end_asked() const noexcept { return end_asked_; }
  /// Ends it here, and says in the log what it came to.
  void end();
  [[nodiscard]] bool ended() const noexcept { return ended_; }
  /// Of the daemon.
  [[nodiscard]] int exit_code() const noexcept { return exit_code_; }

  /// What is told of it with the State of `tick`.
  void fill(std::uint64_t tick, v1::ReplayState& state) const;

 private:
  Parts parts_;
  std::unique_ptr<ReplayRun> run_;
  bool verify_;
  bool paced_;  ///< by the real clock
  std::int64_t due_ns_ = 0;
  bool end_asked_ = false;
  bool ended_ = false;
  int exit_code_ = kExitGood;
};

}  // namespace hapticd
