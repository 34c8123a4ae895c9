// The clock by order alone: no duration is asserted.
#include "core/rt/monotonic_clock.h"

#include <doctest/doctest.h>

#include <chrono>
#include <cstdint>

TEST_CASE("the monotonic clock never goes back") {
  bool forward = true;
  std::int64_t last = hapticd::monotonic_now_ns();
  for (int i = 0; i < 100'000; ++i) {
    const std::int64_t now = hapticd::monotonic_now_ns();
    forward = forward && now >= last;
    last = now;
  }
  CHECK(forward);
}

TEST_CASE("a reading lies between two readings of the standard library's steady clock, in ns") {
  const auto steady_ns = [] {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  bool between = true;
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t before = steady_ns();
    const std::int64_t now = hapticd::monotonic_now_ns();
    between = between && before <= now && now <= steady_ns();
  }
  CHECK(between);
}
