// The delay measured from echoes. Truth: the delays the samples and echoes were made with.
#include "core/safety/echo_watch.h"

#include <doctest/doctest.h>

#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST_CASE("a constant delay is measured to the nanosecond, for every delay that is remembered") {
  for (const std::int64_t delay_ns : {0L, 1L, 700'000L, 3 * kMs, 200 * kMs, 510 * kMs}) {
    CAPTURE(delay_ns);
    EchoWatch watch;
    std::uint64_t echoed = 0;
    for (std::uint64_t k = 1; k <= 2000; ++k) {
      const auto t_ns = static_cast<std::int64_t>(k) * kMs;
      note_sample(k, t_ns, watch);
      while (static_cast<std::int64_t>(echoed + 1) * kMs + delay_ns <= t_ns) {
        ++echoed;
        note_echo(echoed, static_cast<std::int64_t>(echoed) * kMs + delay_ns, watch);
      }
    }
    CHECK(watch.estimator.estimate_ns == delay_ns);
  }
}

TEST_CASE("a command echoed again and again counts once, with its first instant") {
  EchoWatch watch;
  for (std::uint64_t k = 1; k <= 600; ++k) {
    const auto t_ns = static_cast<std::int64_t>(k) * kMs;
    note_sample(k, t_ns, watch);
    note_echo(k, t_ns + 2 * kMs, watch);
    for (int again = 3; again < 9; ++again) note_echo(k, t_ns + again * kMs, watch);
  }
  CHECK(watch.estimator.estimate_ns == 2 * kMs);
}

TEST_CASE("echoes of nothing, of what is forgotten and of the future tell nothing") {
  EchoWatch watch;
  for (std::uint64_t k = 1; k <= 4000; ++k) {
    note_sample(k, static_cast<std::int64_t>(k) * kMs, watch);
    if (k > kEchoMemory) note_echo(k - kEchoMemory, static_cast<std::int64_t>(k) * kMs, watch);
    note_echo(0, 5 * kMs, watch);
  }
  CHECK(watch.estimator.estimate_ns == -1);
  EchoWatch early;
  for (std::uint64_t k = 1; k <= 4000; ++k) {
    note_sample(k, static_cast<std::int64_t>(k) * kMs, early);
    note_echo(k + 1, static_cast<std::int64_t>(k) * kMs, early);
  }
  CHECK(early.estimator.estimate_ns == -1);
}

TEST_CASE("of delays that scatter the estimate is one that fewer than 2 in 100 exceed") {
  SplitMix64 random(11);
  EchoWatch watch;
  for (std::uint64_t k = 1; k <= kDelaySamples; ++k) {
    const auto t_ns = static_cast<std::int64_t>(k) * kMs;
    note_sample(k, t_ns, watch);
    note_echo(k, t_ns + static_cast<std::int64_t>(1e6 * random.uniform(0.0, 1.0)), watch);
  }
  CHECK(watch.estimator.estimate_ns > 950'000);
  CHECK(watch.estimator.estimate_ns < 1'000'000);
}

}  // namespace
}  // namespace hapticd::test
