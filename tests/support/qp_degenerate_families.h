// Seeded quadratic programs that break active-set methods: copies, redundant, opposed and nearly
// parallel rows, wedges, cones, ties. Every problem has a feasible point unless its name says
// otherwise. As qp_families.h each function fills only what `unknowns` and `rows` cover. Not RT:
// tests only.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/solver/qp_problem.h"
#include "tests/support/qp_families.h"
#include "tests/support/random.h"

namespace hapticd::test {

/// Sixty spheres of a finger on one string, a quarter of them exact copies: rows of rank two.
inline void one_string_problem(SplitMix64& random, QpProblem& problem) noexcept {
  contact_problem(random, 0, problem);
  std::array<double, 3> n = random.direction();
  n[0] = 0.0;
  const double length = std::sqrt(n[1] * n[1] + n[2] * n[2]);
  n[1] /= length;
  n[2] /= length;
  const double gap = random.uniform(-20e-6, 1e-3);
  while (problem.rows < 60) {
    if (problem.rows > 0 && random.chance(0.25)) {
      const std::size_t i = random.below(rows_of(problem));
      add_row(problem, row_of(problem, i), problem.bound[i]);
    } else {
      const std::array<double, 3> a = {random.uniform(-0.03, 0.03), -0.005 * n[1], -0.005 * n[2]};
      add_row(problem, contact_row(n, a), -gap);
    }
  }
  // Press into the string, wherever the target was.
  for (std::size_t k = 0; k < 3; ++k) problem.target[k] -= 5e-3 * n[k];
}

/// A few rows and many combinations of them with weights >= 0: implied, with the implied bound or
/// a weaker one.
inline void redundant_problem(SplitMix64& random, QpProblem& problem) noexcept {
  start_problem(random, random_count(random, 1, kMaxDenseUnknowns), problem);
  const QpVector inside = random_point(random, problem);
  const int base = random_count(random, 1, problem.unknowns + 2);
  while (problem.rows < base) {
    add_row_at(random, problem, random_row(random, problem), inside, 1.0);
  }
  const int rows = random_count(random, base, 60);
  while (problem.rows < rows) {
    QpVector row{};
    double bound = 0.0;
    for (int part = random_count(random, 1, 3); part > 0; --part) {
      const std::size_t i = random.below(static_cast<std::uint64_t>(base));
      const double share = random.uniform();
      for (std::size_t k = 0; k < unknowns_of(problem); ++k) row[k] += share * problem.row[k][i];
      bound += share * problem.bound[i];
    }
    const double weaker = random.chance(0.5) ? 0.0 : random.uniform() * scaled_length(problem, row);
    add_row(problem, row, bound - weaker);
  }
}

/// Slabs without width: a . x >= b and -a . x >= -b, the second in another scale.
inline void zero_width_problem(SplitMix64& random, QpProblem& problem) noexcept {
  start_problem(random, random_count(random, 1, kMaxDenseUnknowns), problem);
  const QpVector inside = random_point(random, problem);
  const int slabs = random_count(random, 1, problem.unknowns);
  for (int slab = 0; slab < slabs; ++slab) {
    QpVector row = random_row(random, problem);
    const double bound = value_at(problem, row, inside);
    add_row(problem, row, bound);
    const double scale = -random_magnitude(random, -6, 6);
    for (double& coefficient : row) coefficient *= scale;
    add_row(problem, row, scale * bound);
  }
  for (int i = random_count(random, 0, 10); i > 0; --i) {
    add_row_at(random, problem, random_row(random, problem), inside, 1.0);
  }
}

/// A few bits of a number of size 1, so that sums of products are exact and a point can lie on a
/// plane without rounding.
inline double short_number(SplitMix64& random) noexcept {
  return static_cast<double>(random_count(random, -500, 500)) * 0x1p-9;
}

/// A problem whose feasible point is known without rounding: 0, as in every sub-step, or `inside`.
inline QpVector start_exact_problem(SplitMix64& random, QpProblem& problem) noexcept {
  start_problem(random, random_count(random, 2, kMaxDenseUnknowns), problem);
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
    problem.weight[k] = random.uniform(0.2, 5.0);
    problem.target[k] = random.uniform(-1.0, 1.0);
  }
  QpVector inside{};
  if (random.chance(0.5)) return inside;
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) inside[k] = short_number(random);
  return inside;
}

inline QpVector short_row(SplitMix64& random, const QpProblem& problem) noexcept {
  QpVector row{};
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) row[k] = short_number(random);
  return row;
}

/// Rows in bundles that differ by 1e-7, some turned round so that they nearly oppose each other.
inline void near_parallel_problem(SplitMix64& random, QpProblem& problem) noexcept {
  const QpVector inside = start_exact_problem(random, problem);
  const int bundles = random_count(random, 1, problem.unknowns);
  for (int bundle = 0; bundle < bundles; ++bundle) {
    const QpVector middle = short_row(random, problem);
    for (int i = random_count(random, 1, 5); i > 0; --i) {
      const QpVector off = short_row(random, problem);
      const double sign = random.chance(0.3) ? -1.0 : 1.0;
      QpVector row{};
      for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
        row[k] = sign * (middle[k] + 0x1p-23 * off[k]);
      }
      add_row_at(random, problem, row, inside, 1.0);
    }
  }
}

/// Two walls that face each other, the room between them `width` (m); negative: no room, the
/// problem is infeasible. Other contact rows have room enough.
inline void slab_problem(SplitMix64& random, double width, QpProblem& problem) noexcept {
  contact_problem(random, 0, problem);
  const std::array<double, 3> n = random.direction();
  const std::array<double, 3> a = random.direction();
  const std::array<double, 3> lever = {0.05 * a[0], 0.05 * a[1], 0.05 * a[2]};
  const double gap = random.uniform(0.0, 2e-3);
  const QpVector row = contact_row(n, lever);
  QpVector opposed{};
  for (std::size_t k = 0; k < 6; ++k) opposed[k] = -row[k];
  const int walls_at = random_count(random, 0, 6);
  for (int i = 0; i < 8; ++i) {
    if (i == walls_at) {
      add_row(problem, row, -gap);
      add_row(problem, opposed, gap - width);
    }
    // Far off; the walls keep the tool from it.
    const std::array<double, 3> other = direction_near(random, n, 0.9);
    add_row(problem, contact_row(other, {0.0, 0.0, 0.0}), -random.uniform(0.02, 0.05));
  }
}

/// Three walls at 120 degrees about the tool, the room between them `width` (m) in all; negative:
/// no room, though any two of them leave some.
inline void prism_problem(SplitMix64& random, double width, QpProblem& problem) noexcept {
  contact_problem(random, 0, problem);
  const std::array<double, 3> n = random.direction();
  const std::array<double, 3> off = random.direction();
  std::array<double, 3> lever = random.direction();
  for (double& component : lever) component *= 0.05;
  const double along = off[0] * n[0] + off[1] * n[1] + off[2] * n[2];
  const double length = std::sqrt(1.0 - along * along);
  std::array<double, 3> left{};
  std::array<double, 3> right{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double across = (off[k] - along * n[k]) / length;
    left[k] = -0.5 * n[k] + std::sqrt(0.75) * across;
    right[k] = -0.5 * n[k] - std::sqrt(0.75) * across;
  }
  const double first = random.uniform(-2e-3, 2e-3);
  const double second = random.uniform(-2e-3, 2e-3);
  add_row(problem, contact_row(n, lever), -first);
  add_row(problem, contact_row(left, lever), -second);
  add_row(problem, contact_row(right, lever), first + second - width);
}

/// All planes meet in one point, three to ten times as many as unknowns, the target beyond it.
inline void cone_tip_problem(SplitMix64& random, QpProblem& problem) noexcept {
  start_problem(random, random_count(random, 1, kMaxDenseUnknowns), problem);
  const QpVector tip = random_point(random, problem);
  const QpVector axis = random_row(random, problem);
  const double flare = random.uniform(0.01, 2.0);
  const int rows = std::min(problem.unknowns * random_count(random, 3, 10), kMaxQpRows);
  while (problem.rows < rows) {
    QpVector row = random_row(random, problem);
    for (std::size_t k = 0; k < unknowns_of(problem); ++k) row[k] = axis[k] + flare * row[k];
    add_row(problem, row, value_at(problem, row, tip));
  }
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
    problem.target[k] = tip[k] - axis[k] / problem.weight[k] * random.uniform(0.5, 2.0);
  }
}

/// A box, axis-parallel, some sides of zero width or given twice, the target anywhere about it.
inline void box_problem(SplitMix64& random, QpProblem& problem) noexcept {
  start_problem(random, random_count(random, 1, kMaxDenseUnknowns), problem);
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
    const double unit = 1.0 / std::sqrt(problem.weight[k]);
    const double low = random.uniform(-0.5, 0.5) * unit;
    const double high = random.chance(0.2) ? low : low + random.uniform() * unit;
    QpVector row{};
    row[k] = 1.0;
    for (int copy = random_count(random, 1, 2); copy > 0; --copy) add_row(problem, row, low);
    row[k] = -1.0;
    for (int copy = random_count(random, 1, 2); copy > 0; --copy) add_row(problem, row, -high);
  }
}

/// Up to four wedges with a common tip that open by 2^-23 to 2^-3, some closed by a third plane,
/// and other planes through the tip or near it; the target is up to ten times as far away.
inline void wedge_problem(SplitMix64& random, QpProblem& problem) noexcept {
  const QpVector tip = start_exact_problem(random, problem);
  const double away = random.chance(0.5) ? 1.0 : 10.0;
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) problem.target[k] *= away;
  for (int wedge = random_count(random, 1, 4); wedge > 0; --wedge) {
    const QpVector side = short_row(random, problem);
    const QpVector up = short_row(random, problem);
    double opening = 1.0;
    for (int halving = random_count(random, 3, 23); halving > 0; --halving) opening *= 0.5;
    QpVector left{};
    QpVector right{};
    QpVector lid{};
    for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
      left[k] = side[k] + opening * up[k];
      right[k] = -side[k] + opening * up[k];
      lid[k] = -up[k];
    }
    add_row(problem, left, value_at(problem, left, tip));
    add_row(problem, right, value_at(problem, right, tip));
    if (random.chance(0.5)) add_row(problem, lid, value_at(problem, lid, tip));
  }
  for (int others = random_count(random, 0, 30); others > 0; --others) {
    add_row_at(random, problem, short_row(random, problem), tip, 1.0);
  }
}

/// Coefficients -1, 0 or 1 and small whole bounds: ties everywhere, zero rows among them.
inline void lattice_problem(SplitMix64& random, QpProblem& problem) noexcept {
  start_problem(random, random_count(random, 1, kMaxDenseUnknowns), problem);
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
    problem.weight[k] = 1.0;
    problem.target[k] = random_count(random, -3, 3);
  }
  const int rows = random_count(random, 0, 60);
  while (problem.rows < rows) {
    QpVector row{};
    for (std::size_t k = 0; k < unknowns_of(problem); ++k) row[k] = random_count(random, -1, 1);
    add_row(problem, row, -random_count(random, 0, 2));
  }
}

/// The target satisfies every row, many of them exactly.
inline void satisfied_problem(SplitMix64& random, QpProblem& problem) noexcept {
  start_problem(random, random_count(random, 1, kMaxDenseUnknowns), problem);
  QpVector target{};
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) target[k] = problem.target[k];
  const int rows = random_count(random, 1, 60);
  while (problem.rows < rows) {
    add_row_at(random, problem, random_row(random, problem), target, 1.0);
  }
}

}  // namespace hapticd::test
