// Truth: counting by hand, and for random late ticks a count over the whole history.
#include "core/safety/overrun_watch.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "core/safety/guardian.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("twenty late ticks in a second are put up with, one more is not") {
  OverrunWatch watch;
  for (std::int64_t k = 0; k < 20; ++k) CHECK_FALSE(watch_overrun(true, k * 10'000'000, watch));
  CHECK(watch_overrun(true, 999'999'999, watch));
  CHECK_FALSE(watch_overrun(false, 1'000'000'000, watch));  // the first is a second old
}

TEST_CASE("the watch says what a count over the last second says") {
  SplitMix64 random(61);
  OverrunWatch watch;
  std::vector<std::int64_t> late;
  std::int64_t now = 0;
  for (std::int64_t i = 0; i < scaled(1'000'000); ++i) {
    now += 1'000'000;
    const bool is_late = random.chance(0.02);
    if (is_late) late.push_back(now);
    const auto recent =
        std::count_if(late.end() - std::min<std::ptrdiff_t>(40, std::ssize(late)), late.end(),
                      [now](std::int64_t t) { return now - t < 1'000'000'000; });
    REQUIRE(watch_overrun(is_late, now, watch) == (recent > 20));
  }
  CHECK(watch.total == late.size());
}

TEST_CASE(
    "the guardian acts once when the heartbeat is older than 5 ms, and again after the next") {
  Guardian guardian;
  CHECK_FALSE(must_write_zero(0, 5'000'000, true, guardian));
  CHECK(must_write_zero(0, 5'000'001, true, guardian));
  CHECK_FALSE(must_write_zero(0, 6'000'000, true, guardian));
  CHECK_FALSE(must_write_zero(6'500'000, 7'000'000, true, guardian));
  CHECK(must_write_zero(6'500'000, 20'000'000, true, guardian));
  CHECK(guardian.stalls == 2);
  CHECK(guardian.longest_ns == 13'500'000);
}

TEST_CASE(
    "the guardian leaves a loop without force alone, and a heartbeat from the future is fresh") {
  Guardian guardian;
  CHECK_FALSE(must_write_zero(0, 1'000'000'000, false, guardian));
  CHECK_FALSE(must_write_zero(9'000'000, 1, true, guardian));
  CHECK(guardian.stalls == 0);
}

}  // namespace hapticd::test
