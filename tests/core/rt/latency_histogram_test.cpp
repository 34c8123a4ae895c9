// The histogram against sorted lists of everything it recorded.
#include "core/rt/latency_histogram.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace {

using namespace hapticd;
using hapticd::test::scaled;
using hapticd::test::SplitMix64;

/// The smallest of `sorted` that numerator/denominator of all do not exceed.
std::int64_t exact_quantile(const std::vector<std::int64_t>& sorted, std::size_t numerator,
                            std::size_t denominator) {
  const std::size_t rank = (sorted.size() * numerator + denominator - 1) / denominator;
  return sorted[rank - 1];
}

/// Never too short, at most 1.6 % too long.
bool is_close(std::int64_t value_ns, std::int64_t truth_ns) {
  return value_ns >= truth_ns &&
         static_cast<double>(value_ns) <= 1.016 * static_cast<double>(truth_ns);
}

LatencyHistogram histogram_of(const std::vector<std::int64_t>& durations) {
  LatencyHistogram histogram;
  for (const std::int64_t duration : durations) record(histogram, duration);
  return histogram;
}

std::vector<std::int64_t> random_durations(SplitMix64& random, std::int64_t count) {
  std::vector<std::int64_t> durations;
  durations.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    // 1 ns to 10 s, as many in each decade.
    durations.push_back(std::llround(std::pow(10.0, random.uniform(0.0, 10.0))));
  }
  return durations;
}

}  // namespace

TEST_CASE(
    "quantiles of random durations from 1 ns to 10 s are within 1.6 percent of the sorted list's") {
  SplitMix64 random(801);
  for (const std::int64_t count : {std::int64_t{1}, std::int64_t{2}, std::int64_t{100},
                                   std::int64_t{999}, scaled(1'000'000)}) {
    std::vector<std::int64_t> durations = random_durations(random, count);
    const LatencyHistogram histogram = histogram_of(durations);
    std::sort(durations.begin(), durations.end());
    bool close = true;
    for (std::size_t permille = 1; permille <= 1000; ++permille) {
      close = close && is_close(quantile_ns(histogram, permille, 1000),
                                exact_quantile(durations, permille, 1000));
    }
    CHECK(close);

    const LatencySummary summary = summarise(histogram);
    CHECK(summary.total == durations.size());
    CHECK(is_close(summary.p50_ns, exact_quantile(durations, 500, 1000)));
    CHECK(is_close(summary.p99_ns, exact_quantile(durations, 990, 1000)));
    CHECK(is_close(summary.p99_9_ns, exact_quantile(durations, 999, 1000)));
    CHECK(summary.max_ns == durations.back());
  }
}

TEST_CASE(
    "a single duration is known to 1.6 percent: all up to 2 us and around every bucket edge") {
  // The longer companion keeps the exactly known maximum out of the answer.
  constexpr std::int64_t kMax = 10'000'000'000;
  const auto reported = [](std::int64_t duration) {
    LatencyHistogram histogram;
    record(histogram, duration);
    record(histogram, kMax);
    return quantile_ns(histogram, 1, 2);
  };
  bool close = true;
  bool exact_when_short = true;
  for (std::int64_t duration = 0; duration <= 2000; ++duration) {
    close = close && is_close(reported(duration), duration);
    if (duration < 128) exact_when_short = exact_when_short && reported(duration) == duration;
  }
  for (std::int64_t octave = 128; octave < kMax; octave *= 2) {
    for (std::int64_t part = 64; part < 128; ++part) {
      for (const std::int64_t offset : {-1, 0, 1}) {
        const std::int64_t duration = octave / 64 * part + offset;
        if (duration < kMax) close = close && is_close(reported(duration), duration);
      }
    }
  }
  CHECK(close);
  CHECK(exact_when_short);
}

TEST_CASE("no quantile exceeds the longest duration, even one in the middle of its bucket") {
  LatencyHistogram histogram;
  record(histogram, 1'000'000);
  record(histogram, 1'000'001);
  CHECK(quantile_ns(histogram, 1, 2) <= 1'000'001);
}

TEST_CASE("an empty histogram reports zeros") {
  const LatencySummary summary = summarise(LatencyHistogram{});
  CHECK(summary.total == 0);
  CHECK(summary.p50_ns == 0);
  CHECK(summary.p99_9_ns == 0);
  CHECK(summary.max_ns == 0);
}

TEST_CASE(
    "durations out of range are counted: negative as zero, longer ones with the exact maximum") {
  LatencyHistogram histogram;
  record(histogram, -5);
  record(histogram, std::numeric_limits<std::int64_t>::min());
  record(histogram, 100);
  CHECK(quantile_ns(histogram, 2, 3) == 0);
  CHECK(histogram.max_ns == 100);

  record(histogram, kLatencyRangeNs - 1);
  record(histogram, kLatencyRangeNs);
  record(histogram, std::numeric_limits<std::int64_t>::max());
  CHECK(histogram.total == 6);
  CHECK(quantile_ns(histogram, 3, 6) == 100);
  CHECK(quantile_ns(histogram, 5, 6) == std::numeric_limits<std::int64_t>::max());
  CHECK(quantile_ns(histogram, 1, 1) == std::numeric_limits<std::int64_t>::max());
}

TEST_CASE("recording does not touch the heap") {
  LatencyHistogram histogram;
  const hapticd::test::NoHeapScope scope;
  for (std::int64_t i = 0; i < 1000; ++i) record(histogram, i * i * i);
  const std::int64_t heap_calls = scope.count();
  CHECK(heap_calls == 0);
}
