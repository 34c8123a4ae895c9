// Durations counted in log-linear buckets, after HdrHistogram (Tene): 64 equal buckets per power of
// two, so a duration is known to 1/64 of itself over the whole range, in fixed memory. Values are
// ns. Plain data: copy it through a TripleBuffer, merge copies. RT: record yes, O(1);
// the rest is for the reading side, O(buckets).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace hapticd {

/// Buckets per power of two. 64: relative error <= 1.6 %. Doubling it halves the error and doubles
/// the memory.
inline constexpr int kLatencyBucketsPerOctave = 64;

/// First duration without its own bucket, 2^34 ns = 17 s (10 s must fit). Longer ones count
/// in the last bucket.
inline constexpr std::int64_t kLatencyRangeNs = std::int64_t{1} << 34;

/// 128 buckets of 1 ns, then 64 for each power of two from 2^7 to 2^33 ns.
inline constexpr std::size_t kLatencyBucketCount = 128 + 64 * 27;

/// Counts of durations, and the exact longest.
struct LatencyHistogram {
  std::array<std::uint64_t, kLatencyBucketCount> counts{};
  std::uint64_t total = 0;
  std::int64_t max_ns = 0;
};
static_assert(std::is_trivially_copyable_v<LatencyHistogram>);

/// The figures worth reporting.
struct LatencySummary {
  std::uint64_t total = 0;
  std::int64_t p50_ns = 0;
  std::int64_t p99_ns = 0;
  std::int64_t p99_9_ns = 0;
  std::int64_t max_ns = 0;
};

/// Counts one duration. Negative ones count as 0.
void record(LatencyHistogram& histogram, std::int64_t duration_ns) noexcept;

/// The smallest recorded duration that at least numerator/denominator of all recorded ones do not
/// exceed, rounded up to the end of its bucket: never too short, at most 1/64 too long (exact below
/// 128 ns and for the longest). 0 when nothing is recorded. 1 <= numerator <= denominator <= 1e6;
/// fewer than 1e13 recorded.
[[nodiscard]] std::int64_t quantile_ns(const LatencyHistogram& histogram, std::uint64_t numerator,
                                       std::uint64_t denominator) noexcept;

/// Count, median, 99 and 99.9 percent quantile, maximum.
[[nodiscard]] LatencySummary summarise(const LatencyHistogram& histogram) noexcept;

}  // namespace hapticd
