// Orthogonal factorisation of the active rows of a projection problem, N = Q R, one column per row,
// in the scaled space z = weight^1/2 x with rows of unit length, together with R^-1 and the
// projection it gives. Grows by one column at a time, Gram-Schmidt done twice where needed (Daniel,
// Gragg, Kaufman, Stewart, "Reorthogonalization and stable algorithms for updating the Gram-Schmidt
// QR factorization", Mathematics of Computation 30, 1976); shrinks by rebuilding the columns behind
// the one removed, so no error accumulates. RT: yes; O(P count) per added column.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "core/math/limits.h"
#include "core/solver/lane_vector.h"

namespace hapticd {

/// Relative size up to which rounding of the rows is believed (their own is about 3e-16). It
/// decides whether a row is a combination of others, whether it is violated, and whether rows
/// contradict each other. Larger: sharp wedges are called infeasible. Smaller: rounding of
/// redundant rows is taken for geometry.
inline constexpr double kQpRounding = 1e-13;

/// Longer vectors are those of many strings, of which each row has the unknowns of one: what is
/// certainly zero is passed over. Shorter ones are dense.
inline constexpr std::size_t kMaxDense = 38;

/// A row in the scaled space: normal . (z - z_target) >= offset.
struct UnitRow {
  LaneVector normal;  ///< unit length
  double offset;      ///< distance the target lacks, signed
  double scale;       ///< 1 / length of the scaled row as given
  std::size_t index;  ///< row of the problem
};

/// A unit vector split along the span of the active normals: a = N combination + rest, N' rest = 0.
struct SplitRow {
  LaneVector rest;
  LaneVector combination;
  double rest_squared;
  /// 1 + |combination|^2: the square of how much rounding of the rows is amplified.
  double amplification_squared;
};

struct ActiveFactor {
  std::size_t count;
  /// Largest amplification of rounding by a row: 1 / sine of its angle to the span of those before.
  double sharpness;
  std::array<UnitRow, kMaxQpUnknowns> row;
  std::array<LaneVector, kMaxQpUnknowns> q;        ///< columns of Q
  std::array<LaneVector, kMaxQpUnknowns> inverse;  ///< columns of R^-1
  /// Pairs of each column of Q beyond which it is zero; of vectors longer than kMaxDense.
  std::array<std::size_t, kMaxQpUnknowns> pairs;
  std::array<double, kMaxQpUnknowns> coordinate;  ///< Q' (z - z_target)
  LaneVector step;        ///< z - z_target, z the projection of the target onto the active planes
  LaneVector multiplier;  ///< u with z - z_target = N u
};

/// Splits the unit vector `a` along the span of the active normals.
template <std::size_t P>
inline void split_row(const ActiveFactor& factor, const LaneVector& a, SplitRow& split) noexcept {
  LaneVector rest;
  LaneVector combination;
  copy<P>(a, rest);
  set_zero<P>(combination);
  double before = 1.0;
  double squared = 1.0;
  // One pass leaves an error of rounding / |rest|; the second removes it ("twice is enough").
  for (int pass = 0; pass < 2; ++pass) {
    std::array<double, kMaxQpUnknowns> along;
    if constexpr (P <= kMaxDense) {
      for (std::size_t j = 0; j < factor.count; ++j) along[j] = dot<P>(rest, factor.q[j]);
      for (std::size_t j = 0; j < factor.count; ++j) {
        add_scaled<P>(rest, -along[j], factor.q[j]);
        add_scaled<P>(combination, along[j], factor.inverse[j]);
      }
    } else {
      for (std::size_t j = 0; j < factor.count; ++j) {
        along[j] = dot(rest, factor.q[j], factor.pairs[j]);
      }
      for (std::size_t j = 0; j < factor.count; ++j) {
        add_scaled(rest, -along[j], factor.q[j], factor.pairs[j]);
        add_scaled(combination, along[j], factor.inverse[j], j / 2 + 1);
      }
    }
    squared = dot<P>(rest, rest);
    if (squared > 0.5 * before) break;
    before = squared;
  }
  copy<P>(rest, split.rest);
  copy<P>(combination, split.combination);
  split.rest_squared = squared;
  split.amplification_squared = 1.0 + dot<P>(combination, combination);
}

/// True when rounding of the rows could make the split row a combination of the active ones.
[[nodiscard]] inline bool is_dependent(const SplitRow& split) noexcept {
  return split.rest_squared <= kQpRounding * kQpRounding * split.amplification_squared;
}

template <std::size_t P>
inline void clear(ActiveFactor& factor) noexcept {
  factor.count = 0;
  factor.sharpness = 1.0;
  set_zero<P>(factor.step);
  set_zero<P>(factor.multiplier);
}

/// Appends `row`, split by this factor and not dependent; count < unknowns.
template <std::size_t P>
inline void append(ActiveFactor& factor, const UnitRow& row, const SplitRow& split) noexcept {
  const std::size_t j = factor.count;
  const double inverse_length = 1.0 / std::sqrt(split.rest_squared);
  const double coordinate = (row.offset - dot<P>(row.normal, factor.step)) * inverse_length;
  scale<P>(split.rest, inverse_length, factor.q[j]);
  scale<P>(split.combination, -inverse_length, factor.inverse[j]);
  factor.inverse[j].set(j, inverse_length);
  if constexpr (P > kMaxDense) factor.pairs[j] = used_pairs<P>(split.rest);
  factor.sharpness = inverse_length > factor.sharpness ? inverse_length : factor.sharpness;
  factor.coordinate[j] = coordinate;
  copy<P>(row.normal, factor.row[j].normal);
  factor.row[j].offset = row.offset;
  factor.row[j].scale = row.scale;
  factor.row[j].index = row.index;
  add_scaled<P>(factor.step, coordinate, factor.q[j]);
  add_scaled<P>(factor.multiplier, coordinate, factor.inverse[j]);
  factor.count = j + 1;
}

/// Removes a column; the later ones move up, in order.
template <std::size_t P>
inline void remove(ActiveFactor& factor, std::size_t column) noexcept {
  const std::size_t old_count = factor.count;
  clear<P>(factor);
  for (std::size_t j = 0; j < column; ++j) {
    const double sharpness = factor.inverse[j][j];
    factor.sharpness = sharpness > factor.sharpness ? sharpness : factor.sharpness;
    add_scaled<P>(factor.step, factor.coordinate[j], factor.q[j]);
    add_scaled<P>(factor.multiplier, factor.coordinate[j], factor.inverse[j]);
  }
  factor.count = column;
  SplitRow split;
  for (std::size_t j = column + 1; j < old_count; ++j) {
    split_row<P>(factor, factor.row[j].normal, split);
    append<P>(factor, factor.row[j], split);
  }
}

/// Removes all columns whose multiplier is negative at once; false when there is none.
template <std::size_t P>
inline bool remove_negative(ActiveFactor& factor) noexcept {
  const std::size_t old_count = factor.count;
  std::array<bool, kMaxQpUnknowns> pulls;
  std::size_t first = old_count;
  for (std::size_t j = old_count; j-- > 0;) {
    pulls[j] = factor.multiplier[j] < 0.0;
    if (pulls[j]) first = j;
  }
  if (first == old_count) return false;
  factor.count = first + 1;
  remove<P>(factor, first);
  SplitRow split;
  for (std::size_t j = first + 1; j < old_count; ++j) {
    if (pulls[j]) continue;
    split_row<P>(factor, factor.row[j].normal, split);
    append<P>(factor, factor.row[j], split);
  }
  return true;
}

}  // namespace hapticd
