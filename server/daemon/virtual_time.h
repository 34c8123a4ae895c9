// Virtual time: stopped, following the real one, or stepped as fast as the machine can. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "server/daemon/loop_desk.h"
#include "server/encoding/state_hash.h"
#include "server/recorder/recorder_thread.h"

namespace hapticd {

class VirtualTime {
 public:
  /// All outlive this.
  struct Parts {
    LoopDesk& loop;
    ServedClients& clients;
    RecorderThread& recorder;
    const StateHash& hash;                      ///< of the ticks of the scene
    std::function<void(std::int64_t)> hand_on;  ///< a tick is over: takes what it told
  };

  VirtualTime(const Parts& parts, std::int64_t period_ns) : parts_(parts), period_ns_(period_ns) {}

  /// Nothing passes before a Run.
  void start() noexcept {}
  /// Some of the ticks that are due; true: more are.
  bool pass(std::int64_t now_ns);
  /// Ticks pass only here.
  [[nodiscard]] bool over() const noexcept { return true; }

  /// Run: time stops, follows the real one, or is stepped, which is answered when it is done.
  [[nodiscard]] Answer run(const RequestId& id, const v1::Run& run);
  /// A Run of steps, if one is under way, ends at once: not all of it could be told.
  void fail_steps();
  /// A Stop waits for a tick: the next one waits for no client.
  void hurry() noexcept { hurried_ = hurried_ || steps_.has_value(); }
  /// Nobody waits for the answer any more: a Run of steps ends.
  void abandon(const RequestId& id);

 private:
  /// A Run of steps under way.
  struct StepRun {
    RequestId request;
    std::uint64_t wanted = 0;
    std::uint64_t done = 0;
    std::uint64_t held_before = 0;
  };

  void step(std::int64_t now_ns);
  void end_steps();

  Parts parts_;
  std::int64_t period_ns_;
  bool live_ = false;  ///< time follows the real one
  std::int64_t due_ns_ = 0;
  std::optional<StepRun> steps_;
  bool hurried_ = false;
};

}  // namespace hapticd
