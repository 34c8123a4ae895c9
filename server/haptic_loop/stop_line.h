// What the loop and the thread of the Stop road share: a Stop that waits, and until when the
// heartbeats of dead-men hold the force on. A few atomic words with one writer each, which no other
// thread can fill or lock: the loop reads them in every tick, whatever waits in its rings. RT: yes.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "core/tick/tick.h"

namespace hapticd {

class StopLine {
 public:
  /// No heartbeat holds the force on, nor is one needed.
  static constexpr std::int64_t kNoHeartbeat = std::numeric_limits<std::int64_t>::max();

  /// What the loop has told.
  struct Told {
    bool waits = false;  ///< a Stop was asked for since the newest tick that is over began
    LoopState state = LoopState::kDetached;
    Cause cause = Cause::kNone;
    std::uint32_t tick = 0;    ///< low bits of that tick's number
    std::uint32_t clears = 0;  ///< Clears that the loop has obeyed
  };

  /// Road. The tick that begins next latches a Stop, and cancels every Clear before it.
  void ask() noexcept {
    if (!waits()) asked_.fetch_add(1, std::memory_order_seq_cst);
  }
  /// Road. Force may be on until `until_ns` of the monotonic clock; kNoHeartbeat: for ever.
  void hold_until(std::int64_t until_ns) noexcept {
    held_until_ns_.store(until_ns, std::memory_order_seq_cst);
  }
  [[nodiscard]] Told told() const noexcept {
    const std::uint64_t word = told_.load(std::memory_order_acquire);
    Told told;
    told.tick = static_cast<std::uint32_t>(word);
    told.state = static_cast<LoopState>((word >> 32U) & 0xffU);
    told.cause = static_cast<Cause>((word >> 40U) & 0xffU);
    told.waits = static_cast<std::uint16_t>(word >> 48U) != asked_.load(std::memory_order_acquire);
    told.clears = clears_.load(std::memory_order_acquire);
    return told;
  }
  /// Any thread. A Stop waits for a tick.
  [[nodiscard]] bool waits() const noexcept {
    const std::uint64_t word = told_.load(std::memory_order_acquire);
    return static_cast<std::uint16_t>(word >> 48U) != asked_.load(std::memory_order_acquire);
  }

  /// Loop. Whether a Stop was asked for since the last call.
  [[nodiscard]] bool take() noexcept {
    const std::uint16_t asked = asked_.load(std::memory_order_seq_cst);
    const bool anew = asked != taken_;
    taken_ = asked;
    return anew;
  }
  /// Loop. Whether a heartbeat that is needed has been absent for too long at `now_ns`.
  [[nodiscard]] bool lets_go(std::int64_t now_ns) const noexcept {
    return now_ns > held_until_ns_.load(std::memory_order_seq_cst);
  }
  /// Loop. It has heard a Clear.
  void note_clear() noexcept { clears_.fetch_add(1, std::memory_order_acq_rel); }
  /// Loop. A tick has come to `state`: the Stops taken before it are obeyed.
  void tell(std::uint64_t tick, LoopState state, Cause cause) noexcept {
    const std::uint64_t word =
        (tick & 0xffff'ffffU) | (std::uint64_t{static_cast<std::uint8_t>(state)} << 32U) |
        (std::uint64_t{static_cast<std::uint8_t>(cause)} << 40U) | (std::uint64_t{taken_} << 48U);
    told_.store(word, std::memory_order_release);
  }

 private:
  std::atomic<std::uint64_t> told_{std::uint64_t{static_cast<std::uint8_t>(LoopState::kDetached)}
                                   << 32U};
  std::atomic<std::uint16_t> asked_{0};
  std::atomic<std::int64_t> held_until_ns_{kNoHeartbeat};
  std::atomic<std::uint32_t> clears_{0};
  std::uint16_t taken_ = 0;  ///< of the loop
};

}  // namespace hapticd
