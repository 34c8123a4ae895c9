// What has come by the Stop road, counted per cause by its thread and read by any other. Not RT.
#pragma once

#include <atomic>
#include <cstdint>

namespace hapticd {

/// One writer, any reader. A copy holds what the count was.
class StopCount {
 public:
  StopCount() = default;
  StopCount(const StopCount& other) noexcept : value_(other.value()) {}
  StopCount& operator=(const StopCount& other) noexcept {
    value_.store(other.value(), std::memory_order_relaxed);
    return *this;
  }
  ~StopCount() = default;

  void add() noexcept {
    value_.store(value_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  [[nodiscard]] std::uint64_t value() const noexcept {
    return value_.load(std::memory_order_relaxed);
  }

 private:
  std::atomic<std::uint64_t> value_{0};
};

struct StopCounters {
  StopCount received;   ///< datagrams of any kind
  StopCount malformed;  ///< another length, mark, version or kind; a field that makes no sense
  StopCount unauthenticated;  ///< no tag where one is needed, or a wrong one
  StopCount replayed;         ///< a challenge that is old, used or of another; a number seen before
  StopCount challenged;       ///< asked without a challenge, which was given
  StopCount other_daemon;     ///< meant for a daemon with another session port
  StopCount full;             ///< heartbeats that found no place
  StopCount unanswered;       ///< obeyed or judged, but the answer was one too many, or not taken
  StopCount stops;            ///< obeyed
  StopCount heartbeats;       ///< that counted
};

}  // namespace hapticd
