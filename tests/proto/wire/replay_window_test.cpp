// The replay window against a set of all counters ever marked.
#include "proto/wire/replay_window.h"

#include <doctest/doctest.h>

#include <set>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::wire {
namespace {

TEST_CASE("a counter is new until it is marked, and not below the window of 2048") {
  ReplayWindow window;
  CHECK(window.is_new(0));
  CHECK(window.is_new(5000));
  window.mark(5000);
  CHECK(!window.is_new(5000));
  CHECK(window.is_new(5001));
  CHECK(window.is_new(4999));
  CHECK(window.is_new(5000 - 2047));
  CHECK(!window.is_new(5000 - 2048));
  CHECK(!window.is_new(0));
}

TEST_CASE("asking marks nothing") {
  ReplayWindow window;
  CHECK(window.is_new(3));
  CHECK(window.is_new(3));
  window.mark(9);
  CHECK(window.is_new(3));
}

TEST_CASE("the window agrees with a list of everything marked, whatever the jumps") {
  test::SplitMix64 random(4);
  for (std::int64_t trial = test::scaled(100); trial > 0; --trial) {
    ReplayWindow window;
    std::set<std::uint64_t> marked;
    std::uint64_t largest = random.chance(0.2) ? ~std::uint64_t{0} - 20'000 : random.below(10);
    for (int i = 0; i < 2000; ++i) {
      const std::uint64_t jump = random.chance(0.02) ? random.below(9000) : random.below(4);
      const std::uint64_t back = random.chance(0.5) ? 0 : random.below(2200);
      const std::uint64_t top = ~std::uint64_t{0} - largest < jump ? largest : largest + jump;
      const std::uint64_t counter = top >= back ? top - back : 0;
      const bool below =
          !marked.empty() && counter < *marked.rbegin() && *marked.rbegin() - counter >= 2048;
      CHECK(window.is_new(counter) == (!below && marked.count(counter) == 0));
      if (window.is_new(counter)) {
        window.mark(counter);
        marked.insert(counter);
        largest = *marked.rbegin();
      }
    }
  }
}

}  // namespace
}  // namespace hapticd::wire
