// The table of dead-men against one that is written as plainly as can be.
#include "server/stop_road/heartbeats.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <map>

#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMs = 1'000'000;

using Verdict = Heartbeats::Verdict;

TEST_CASE("force is held on by the client that will be silent too long first") {
  Heartbeats table;
  CHECK(table.earliest_ns(kNone) == kNone);
  CHECK(table.beat(7, 1, 50 * kMs, 1000 * kMs) == Verdict::kCounts);
  CHECK(table.beat(8, 1, 1000 * kMs, 1000 * kMs) == Verdict::kCounts);
  CHECK(table.earliest_ns(kNone) == 1050 * kMs);
  CHECK(table.beat(7, 2, 500 * kMs, 1040 * kMs) == Verdict::kCounts);
  CHECK(table.earliest_ns(kNone) == 1540 * kMs);
  CHECK(table.leave(7, 3, 1041 * kMs) == Verdict::kCounts);
  CHECK(table.earliest_ns(kNone) == 2000 * kMs);
  CHECK(table.leave(8, 2, 1042 * kMs) == Verdict::kCounts);
  CHECK(table.earliest_ns(kNone) == kNone);
}

TEST_CASE("an absent client is waited for until a Clear lets go of it, and comes back by itself") {
  Heartbeats table;
  REQUIRE(table.beat(7, 5, 50 * kMs, 0) == Verdict::kCounts);
  table.forget_absent(50 * kMs);
  CHECK(table.count() == 1);
  table.forget_absent(3'600'000 * kMs);
  CHECK(table.count() == 0);
  // One that was recorded before does not come back for it.
  CHECK(table.beat(7, 5, 50 * kMs, 3'600'001 * kMs) == Verdict::kRepeated);
  CHECK(table.count() == 0);
  CHECK(table.beat(7, 6, 50 * kMs, 3'600'002 * kMs) == Verdict::kCounts);
  CHECK(table.count() == 1);
}

TEST_CASE("the table does what a map without an end does, as long as it has places") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  Heartbeats table;
  struct Client {
    std::uint64_t number = 0;
    std::int64_t until_ns = 0;
    bool needed = false;
  };
  std::map<std::uint64_t, Client> truth;
  std::int64_t now_ns = 1;
  // More clients than places, some of which cannot be had.
  for (int k = 0; k < scaled(200'000); ++k) {
    now_ns += static_cast<std::int64_t>(random.below(30)) * kMs;
    const std::uint64_t client = 1 + random.below(kMaxHeartbeats + 3);
    const auto known = truth.find(client);
    const std::uint64_t last = known == truth.end() ? 0 : known->second.number;
    const std::uint64_t number = std::max<std::uint64_t>(1, last + random.below(4) - 1);
    const std::int64_t timeout_ns = (50 + static_cast<std::int64_t>(random.below(951))) * kMs;
    const std::uint64_t what = random.below(10);
    // Whether the table still knows of it is its own business.
    const bool old =
        known != truth.end() && !known->second.needed && known->second.until_ns < now_ns;
    if (old && what > 0 && what <= 2) continue;
    if (what == 0) {
      table.forget_absent(now_ns);
      for (auto& [id, each] : truth) {
        if (each.needed && each.until_ns < now_ns)
          each = {each.number, now_ns + kGoneMemory_ns, false};
      }
    } else if (what <= 2) {
      const Verdict verdict = table.leave(client, number, now_ns);
      if (known == truth.end()) {
        CHECK(verdict == Verdict::kCounts);
      } else if (number <= last) {
        CHECK(verdict == Verdict::kRepeated);
      } else {
        CHECK(verdict == Verdict::kCounts);
        known->second = {number, now_ns + kGoneMemory_ns, false};
      }
    } else {
      const Verdict verdict = table.beat(client, number, timeout_ns, now_ns);
      if (verdict == Verdict::kFull) {
        // Whoever is remembered has a place, so all places are others'.
        const auto held = std::count_if(truth.begin(), truth.end(), [&](const auto& each) {
          return each.second.needed || each.second.until_ns >= now_ns;
        });
        CHECK(held >= static_cast<std::ptrdiff_t>(kMaxHeartbeats));
      } else if (known != truth.end() && number <= last) {
        CHECK((verdict == Verdict::kRepeated || old));
        if (verdict == Verdict::kCounts) known->second = {number, now_ns + timeout_ns, true};
      } else {
        CHECK(verdict == Verdict::kCounts);
        truth[client] = {number, now_ns + timeout_ns, true};
      }
    }
    std::int64_t earliest_ns = kNone;
    std::size_t needed = 0;
    for (const auto& [id, each] : truth) {
      if (!each.needed) continue;
      ++needed;
      earliest_ns = std::min(earliest_ns, each.until_ns);
    }
    REQUIRE(table.earliest_ns(kNone) == earliest_ns);
    REQUIRE(table.count() == needed);
  }
}

}  // namespace
}  // namespace hapticd::test
