// Counters that wrap against ones of 64 bits that do not: the truth is the 64-bit count whose low
// bits are given.
#include "device/hid/counter_unwrap.h"

#include <doctest/doctest.h>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

template <typename Raw>
void check_against_wide_count(std::uint64_t seed) {
  constexpr std::uint64_t kTurn = std::uint64_t{std::numeric_limits<Raw>::max()} + 1;
  SplitMix64 random(seed);
  const std::uint64_t first = random.below(kTurn);
  std::uint64_t truth = first;
  hid::CounterUnwrap<Raw> counter;
  CHECK(hid::unwrap(static_cast<Raw>(truth), counter) == kTurn + first);
  std::int64_t wrong = 0;
  for (std::int64_t k = 0; k < scaled(1'000'000); ++k) {
    truth += random.chance(0.9) ? 1 : random.below(kTurn / 2);
    wrong += hid::unwrap(static_cast<Raw>(truth), counter) != kTurn + truth ? 1 : 0;
    // One that came before tells its own value and moves nothing.
    const std::uint64_t back = random.below(kTurn / 2);
    if (back <= truth - first) {
      wrong += hid::unwrap(static_cast<Raw>(truth - back), counter) != kTurn + truth - back ? 1 : 0;
    }
    wrong += counter.newest != kTurn + truth ? 1 : 0;
  }
  CHECK(wrong == 0);
}

TEST_CASE("a sequence number of 16 bits goes on counting where it wraps") {
  check_against_wide_count<std::uint16_t>(1);
  hid::CounterUnwrap<std::uint16_t> counter;
  CHECK(hid::unwrap<std::uint16_t>(65'535, counter) == 131'071);
  CHECK(hid::unwrap<std::uint16_t>(0, counter) == 131'072);
}

TEST_CASE("a clock of 32 bits goes on counting where it wraps") {
  check_against_wide_count<std::uint32_t>(2);
  hid::CounterUnwrap<std::uint32_t> clock;
  CHECK(hid::unwrap<std::uint32_t>(4'294'967'295U, clock) == 8'589'934'591U);
  CHECK(hid::unwrap<std::uint32_t>(999, clock) == 8'589'935'591U);
}

TEST_CASE("the same value again is the same value, and half a turn ahead is behind") {
  hid::CounterUnwrap<std::uint16_t> counter;
  CHECK(hid::unwrap<std::uint16_t>(7, counter) == 65'543);
  CHECK(hid::unwrap<std::uint16_t>(7, counter) == 65'543);
  CHECK(hid::unwrap<std::uint16_t>(7 + 32'768, counter) == 65'543 - 32'768);
  CHECK(hid::unwrap<std::uint16_t>(7 + 32'767, counter) == 65'543 + 32'767);
}

}  // namespace
}  // namespace hapticd::test
