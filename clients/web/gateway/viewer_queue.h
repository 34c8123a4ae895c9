// What waits to be sent to one viewer. A State that is not the newest is worth little: of too many
// the oldest go. Everything else arrives, or the viewer has to be closed. Pure. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "clients/web/gateway/page_event.h"

namespace hapticd::web {

/// How much may wait.
struct QueueLimits {
  /// States. At 250 a second 32 are an eighth of one: what a viewer on a bad link lags behind at
  /// most, beside what its socket holds. More: a stutter is smoothed, and the past shown for
  /// longer.
  std::size_t states = 32;
  /// Events that are not States: some seconds of the fastest play. A viewer that is further behind
  /// does not come back by itself.
  std::size_t kept = 1024;
  /// Bytes of them together; one alone may be longer (a large scene).
  std::size_t kept_bytes = 8U << 20U;
};

/// The events of one viewer, numbered from 1 as they come.
class ViewerQueue {
 public:
  explicit ViewerQueue(const QueueLimits& limits = {}) noexcept : limits_(limits) {}

  /// A State; where too many wait the oldest of them goes.
  void add_state(SharedBody body);
  /// Anything else. False: there is no place, and nothing was added; the viewer is lost.
  [[nodiscard]] bool add(SharedBody body);
  /// The next message, whole; nothing when none waits.
  [[nodiscard]] std::optional<std::string> take();

  /// States that had to go so far.
  [[nodiscard]] std::uint64_t dropped_states() const noexcept { return dropped_; }
  [[nodiscard]] std::size_t size() const noexcept { return waiting_.size(); }

 private:
  struct Waiting {
    std::uint64_t sequence;
    bool is_state;
    SharedBody body;
  };

  QueueLimits limits_;
  std::deque<Waiting> waiting_;
  std::uint64_t sequence_ = 0;
  std::size_t states_ = 0;      ///< in waiting_
  std::size_t kept_bytes_ = 0;  ///< of the others in it
  std::uint64_t dropped_ = 0;
};

}  // namespace hapticd::web
