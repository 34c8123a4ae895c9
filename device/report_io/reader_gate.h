// Who may read from a channel: the loop, while the channel is attached and has not failed. One
// word, so that the loop never waits for the thread that opens and closes devices; that thread
// waits for the loop, which is in the channel for microseconds, or for a tick where it waits for a
// report there. A gate that is to be closed lets no reader in again, so that it closes although the
// reader comes back at once. RT: enter, leave and attachment.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "core/math/realtime.h"

namespace hapticd {

/// Closed at first.
class ReaderGate {
 public:
  /// Lets the reader in. The channel must be in place. Not RT; one thread opens and closes.
  void open() noexcept {
    attachments_.fetch_add(1, std::memory_order_relaxed);
    state_.store(State::kIdle, std::memory_order_release);
  }

  /// Returns when the reader is out, and keeps it out. Not RT.
  void close() noexcept {
    State seen = state_.load();
    while (seen != State::kClosed) {
      const State next =
          seen == State::kReading || seen == State::kClosing ? State::kClosing : State::kClosed;
      if (!state_.compare_exchange_weak(seen, next, std::memory_order_acq_rel)) continue;
      if (next == State::kClosing) std::this_thread::yield();
      seen = state_.load(std::memory_order_acquire);
    }
  }

  /// True: the channel may be read until leave(). Loop's thread.
  [[nodiscard]] HD_REALTIME bool enter() noexcept {
    State expected = State::kIdle;
    return state_.compare_exchange_strong(expected, State::kReading, std::memory_order_acq_rel);
  }

  /// After enter(). `lost`: never again, until the next open().
  HD_REALTIME void leave(bool lost) noexcept {
    State expected = State::kReading;
    const State next = lost ? State::kFailed : State::kIdle;
    if (state_.compare_exchange_strong(expected, next, std::memory_order_acq_rel)) return;
    state_.store(State::kClosed, std::memory_order_release);
  }

  /// The reader has found the device lost. Any thread.
  [[nodiscard]] HD_REALTIME bool failed() const noexcept {
    return state_.load(std::memory_order_relaxed) == State::kFailed;
  }

  /// Times it was opened: another number is another channel. Within enter() and leave(), or from
  /// the thread that opens and closes.
  [[nodiscard]] HD_REALTIME std::uint32_t attachment() const noexcept {
    return attachments_.load(std::memory_order_relaxed);
  }

 private:
  enum class State : std::uint8_t {
    kClosed,
    kIdle,
    kReading,
    kClosing,  ///< to be closed by the reader, which is still in
    kFailed
  };

  std::atomic<State> state_{State::kClosed};
  std::atomic<std::uint32_t> attachments_{0};
};

}  // namespace hapticd
