// Small dense vectors of the active-set solver: doubles in pairs, the width every x86-64 has, so
// that one code serves baseline and newer processors with equal bits. P is the number of unknowns
// rounded up to an even number; entries beyond the unknowns are zero. RT: yes; O(P) per call.
#pragma once

#include <array>
#include <cstddef>

#include "core/math/limits.h"

namespace hapticd {

/// Two doubles that are added and multiplied together.
struct DoublePair {
  using Vector [[gnu::vector_size(16)]] = double;
  Vector value;
};

inline constexpr std::size_t kQpPairs = (kMaxQpUnknowns + 1) / 2;

struct LaneVector {
  std::array<DoublePair, kQpPairs> pair;

  [[nodiscard]] double operator[](std::size_t k) const noexcept { return pair[k / 2].value[k % 2]; }
  void set(std::size_t k, double value) noexcept { pair[k / 2].value[k % 2] = value; }
};

template <std::size_t P>
inline void set_zero(LaneVector& a) noexcept {
  for (std::size_t i = 0; i < P / 2; ++i) a.pair[i].value = DoublePair::Vector{0.0, 0.0};
}

template <std::size_t P>
inline void copy(const LaneVector& from, LaneVector& to) noexcept {
  for (std::size_t i = 0; i < P / 2; ++i) to.pair[i].value = from.pair[i].value;
}

/// to = factor from; may be the same vector.
template <std::size_t P>
inline void scale(const LaneVector& from, double factor, LaneVector& to) noexcept {
  for (std::size_t i = 0; i < P / 2; ++i) to.pair[i].value = from.pair[i].value * factor;
}

/// a += factor b.
template <std::size_t P>
inline void add_scaled(LaneVector& a, double factor, const LaneVector& b) noexcept {
  for (std::size_t i = 0; i < P / 2; ++i) a.pair[i].value += b.pair[i].value * factor;
}

/// a . b: even and odd entries are summed apart, in order, then together.
template <std::size_t P>
[[nodiscard]] inline double dot(const LaneVector& a, const LaneVector& b) noexcept {
  DoublePair::Vector sum = a.pair[0].value * b.pair[0].value;
  for (std::size_t i = 1; i < P / 2; ++i) sum += a.pair[i].value * b.pair[i].value;
  return sum[0] + sum[1];
}

/// The same over the first `pairs` pairs alone.
inline void add_scaled(LaneVector& a, double factor, const LaneVector& b,
                       std::size_t pairs) noexcept {
  for (std::size_t i = 0; i < pairs; ++i) a.pair[i].value += b.pair[i].value * factor;
}
[[nodiscard]] inline double dot(const LaneVector& a, const LaneVector& b,
                                std::size_t pairs) noexcept {
  DoublePair::Vector sum = a.pair[0].value * b.pair[0].value;
  for (std::size_t i = 1; i < pairs; ++i) sum += a.pair[i].value * b.pair[i].value;
  return sum[0] + sum[1];
}

/// Pairs up to the last that is not zero; at least 1.
template <std::size_t P>
[[nodiscard]] inline std::size_t used_pairs(const LaneVector& a) noexcept {
  std::size_t pairs = P / 2;
  while (pairs > 1 && a.pair[pairs - 1].value[0] == 0.0 && a.pair[pairs - 1].value[1] == 0.0) {
    --pairs;
  }
  return pairs;
}

}  // namespace hapticd
