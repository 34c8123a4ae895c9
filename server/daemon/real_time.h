// The loop on a thread of its own, under the real clock. Not RT.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "proto/wire/request_result.h"
#include "server/daemon/served_clients.h"
#include "server/haptic_loop/realtime_thread.h"

namespace hapticd {

class RealTime {
 public:
  /// `loop` outlives this.
  RealTime(HapticLoop& loop, const RealtimeOptions& options) : loop_(loop), options_(options) {}

  /// Ticks pass from here on. Throws std::runtime_error when realtime is required and refused.
  void start() { thread_ = std::make_unique<RealtimeThread>(loop_, options_); }
  /// Ticks pass without help.
  [[nodiscard]] bool pass(std::int64_t /*now_ns*/) noexcept { return false; }
  /// No tick changes anything any more.
  [[nodiscard]] bool over() const noexcept { return thread_->over(); }

  /// Run: it does nothing else than it does.
  [[nodiscard]] static Answer run(const v1::Run& run);

  /// No tick passes any more.
  void stop() { thread_.reset(); }
  /// What the thread would have liked to have.
  [[nodiscard]] const std::vector<MissingPrivilege>& missing() const { return thread_->missing(); }

 private:
  HapticLoop& loop_;
  RealtimeOptions options_;
  std::unique_ptr<RealtimeThread> thread_;
};

inline Answer RealTime::run(const v1::Run& run) {
  if (run.mode() == v1::RUN_MODE_LIVE) return wire::result_of(v1::RESULT_CODE_OK);
  return wire::result_of(
      v1::RESULT_CODE_WRONG_STATE, "run.mode",
      "The real clock cannot be stopped or stepped. Start hapticd with --clock virtual.");
}

}  // namespace hapticd
