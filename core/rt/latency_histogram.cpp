// Bucket arithmetic of the latency histogram. A duration below 128 ns is its own bucket. A longer
// one keeps its 7 leading bits, which number 64..127 within its power of two; the buckets of each
// power follow those of the one before. RT: record only.
#include "core/rt/latency_histogram.h"

#include <algorithm>
#include <bit>

namespace hapticd {
namespace {

/// Bucket of a duration in [0, kLatencyRangeNs).
std::size_t bucket_of(std::int64_t duration_ns) noexcept {
  const auto duration = static_cast<std::uint64_t>(duration_ns);
  const int dropped_bits = std::max(0, static_cast<int>(std::bit_width(duration)) - 7);
  return static_cast<std::size_t>(dropped_bits * kLatencyBucketsPerOctave) +
         static_cast<std::size_t>(duration >> dropped_bits);
}

/// Longest duration of a bucket, ns.
std::int64_t end_of_bucket(std::size_t bucket) noexcept {
  constexpr std::size_t kOctave = kLatencyBucketsPerOctave;
  const std::size_t dropped_bits = bucket < 2 * kOctave ? 0 : bucket / kOctave - 1;
  const std::size_t leading = bucket - dropped_bits * kOctave;
  return static_cast<std::int64_t>(((leading + 1) << dropped_bits) - 1);
}

}  // namespace

void record(LatencyHistogram& histogram, std::int64_t duration_ns) noexcept {
  const std::int64_t duration = std::max<std::int64_t>(0, duration_ns);
  ++histogram.counts[bucket_of(std::min(duration, kLatencyRangeNs - 1))];
  ++histogram.total;
  histogram.max_ns = std::max(histogram.max_ns, duration);
}

std::int64_t quantile_ns(const LatencyHistogram& histogram, std::uint64_t numerator,
                         std::uint64_t denominator) noexcept {
  if (histogram.total == 0) return 0;
  const std::uint64_t rank = (histogram.total * numerator + denominator - 1) / denominator;
  if (rank >= histogram.total) return histogram.max_ns;
  std::uint64_t passed = 0;
  std::size_t bucket = 0;
  while (passed + histogram.counts[bucket] < rank) passed += histogram.counts[bucket++];
  // The last bucket also holds what is beyond the range.
  if (bucket + 1 == kLatencyBucketCount) return histogram.max_ns;
  return std::min(end_of_bucket(bucket), histogram.max_ns);
}

LatencySummary summarise(const LatencyHistogram& histogram) noexcept {
  return {histogram.total, quantile_ns(histogram, 50, 100), quantile_ns(histogram, 99, 100),
          quantile_ns(histogram, 999, 1000), histogram.max_ns};
}

}  // namespace hapticd
