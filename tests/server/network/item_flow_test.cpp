// Who holds virtual time up, and for how long at worst.
#include "server/network/item_flow.h"

#include <doctest/doctest.h>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A peer that acknowledges as it likes while Items are made whenever it does not hold time up.
struct Peer {
  ItemFlow flow;
  std::uint64_t made = 0;
  std::uint64_t acknowledged = 0;
  std::int64_t now_ns = 0;
  std::int64_t waited_ns = 0;

  [[nodiscard]] std::uint64_t waiting() const { return made - acknowledged; }
  /// A millisecond, in which it acknowledges `count`; up to `events` Items are made if time runs.
  void pass(std::uint64_t count, std::uint64_t events) {
    now_ns += kMs;
    acknowledged += std::min(count, waiting());
    flow.note(waiting(), acknowledged, now_ns);
    if (flow.behind() && flow.progresses(now_ns)) {
      waited_ns += kMs;
    } else {
      made += events;
    }
  }
};

}  // namespace

TEST_CASE("time waits from 257 Items on until 128 are left") {
  ItemFlow flow;
  for (std::size_t count = 0; count <= 256; ++count) {
    flow.note(count, 0, 0);
    CHECK_FALSE(flow.behind());
  }
  flow.note(257, 0, 0);
  for (std::size_t count = 257; count > 128; --count) {
    flow.note(count, 257 - count, 0);
    CHECK(flow.behind());
  }
  flow.note(128, 129, 0);
  CHECK_FALSE(flow.behind());
  flow.note(256, 129, 0);
  CHECK_FALSE(flow.behind());
}

TEST_CASE("a peer that acknowledges nothing holds time up for a quarter of a second") {
  Peer peer;
  for (int k = 0; k < 10'000; ++k) peer.pass(0, 1);
  CHECK(peer.waited_ns <= 251 * kMs);
  CHECK(peer.waiting() > 9000);
}

// 16 Items in 250 ms, and an eighth more for the quarter of a second that each of its delays, of
// 128 Items at least, begins with.
TEST_CASE("however a peer acknowledges, it holds time up by 1 s for 56 Items at most") {
  const auto check = [](const Peer& peer) {
    const double items = static_cast<double>(peer.acknowledged);
    CHECK(static_cast<double>(peer.waited_ns) * 1e-9 <= items / 56.0 + 0.3);
  };
  // The meanest: one Item whenever its time is nearly over, or just enough of them.
  for (const std::uint64_t count : {1U, 15U, 16U, 17U}) {
    for (const int every_ms : {1, 15, 100, 249, 250, 251}) {
      Peer peer;
      for (int k = 0; k < 60'000; ++k) peer.pass(k % every_ms == 0 ? count : 0, 1 + (k % 7 == 0));
      check(peer);
    }
  }
  SplitMix64 random(7);
  for (std::int64_t n = scaled(2000); n > 0; --n) {
    Peer peer;
    for (int k = 0; k < 20'000;) {
      const std::uint64_t count = random.below(random.chance(0.1) ? 300 : 20);
      const std::uint64_t still = random.below(random.chance(0.5) ? 260 : 10);
      const std::uint64_t events = random.below(4);
      peer.pass(count, events);
      for (std::uint64_t i = 0; i < still; ++i, ++k) peer.pass(0, events);
      ++k;
    }
    check(peer);
  }
}

}  // namespace hapticd::test
