// Seeded quadratic programs for the tests and benchmarks of core/solver: contact rows as a tool
// makes them, rows without structure, and what may be done to a problem without changing its
// solution. Every problem has a feasible point. Each function fills `unknowns`, `rows` and just the
// entries these cover; the rest of the arrays stays as it was. Not RT: tests and benchmarks only.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/solver/qp_problem.h"
#include "tests/support/random.h"

namespace hapticd::test {

using QpVector = std::array<double, kMaxQpUnknowns>;

/// 10^exponent, exact for |exponent| <= 22 and exponent >= 0, else within one rounding.
inline double power_of_ten(int exponent) noexcept {
  double power = 1.0;
  for (int e = 0; e < std::abs(exponent); ++e) power *= 10.0;
  return exponent < 0 ? 1.0 / power : power;
}

/// Between 10^low and 10^high, spread evenly over the decades.
inline double random_magnitude(SplitMix64& random, int low, int high) noexcept {
  const auto decades = static_cast<std::uint64_t>(high - low);
  const double power = power_of_ten(low + static_cast<int>(random.below(decades)));
  return random.uniform(1.0, 10.0) * power;
}

inline int random_count(SplitMix64& random, int low, int high) noexcept {
  const auto count = static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low) + 1;
  return low + static_cast<int>(random.below(count));
}

inline std::size_t unknowns_of(const QpProblem& problem) noexcept {
  return static_cast<std::size_t>(problem.unknowns);
}

inline std::size_t rows_of(const QpProblem& problem) noexcept {
  return static_cast<std::size_t>(problem.rows);
}

/// Appends a row; the caller keeps below kMaxQpRows.
inline void add_row(QpProblem& problem, const QpVector& row, double bound) noexcept {
  const std::size_t i = rows_of(problem);
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) problem.row[k][i] = row[k];
  problem.bound[i] = bound;
  ++problem.rows;
}

inline QpVector row_of(const QpProblem& problem, std::size_t i) noexcept {
  QpVector row{};
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) row[k] = problem.row[k][i];
  return row;
}

inline double value_at(const QpProblem& problem, const QpVector& row, const QpVector& x) noexcept {
  double value = 0.0;
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) value += row[k] * x[k];
  return value;
}

/// Length of a row in the scaled space.
inline double scaled_length(const QpProblem& problem, const QpVector& row) noexcept {
  double squared = 0.0;
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
    squared += row[k] * row[k] / problem.weight[k];
  }
  return std::sqrt(squared);
}

/// Entries of size 1 in the scaled space.
inline QpVector random_row(SplitMix64& random, const QpProblem& problem) noexcept {
  QpVector row{};
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
    row[k] = random.uniform(-1.0, 1.0) * std::sqrt(problem.weight[k]);
  }
  return row;
}

/// A point of size 1 in the scaled space.
inline QpVector random_point(SplitMix64& random, const QpProblem& problem) noexcept {
  QpVector x{};
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
    x[k] = random.uniform(-1.0, 1.0) / std::sqrt(problem.weight[k]);
  }
  return x;
}

/// Weights from 1e-3 to 1e9 and a target of size 1 in the scaled space; no rows yet.
inline void start_problem(SplitMix64& random, int unknowns, QpProblem& problem) noexcept {
  problem.unknowns = unknowns;
  problem.rows = 0;
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
    problem.weight[k] = random_magnitude(random, -3, 9);
  }
  const QpVector target = random_point(random, problem);
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) problem.target[k] = target[k];
}

/// Row through the point `inside` or up to `room` away from it (in the scaled space).
inline void add_row_at(SplitMix64& random, QpProblem& problem, const QpVector& row,
                       const QpVector& inside, double room) noexcept {
  const double distance = random.chance(0.3) ? 0.0 : random.uniform(0.0, room);
  add_row(problem, row, value_at(problem, row, inside) - distance * scaled_length(problem, row));
}

/// Row of a contact with normal `n` at lever `a` (m): n . dp + (a x n) . dtheta.
inline QpVector contact_row(const std::array<double, 3>& n,
                            const std::array<double, 3>& a) noexcept {
  return {n[0],
          n[1],
          n[2],
          a[1] * n[2] - a[2] * n[1],
          a[2] * n[0] - a[0] * n[2],
          a[0] * n[1] - a[1] * n[0]};
}

/// Unit vector within asin(spread) of `axis`; spread < 1.
inline std::array<double, 3> direction_near(SplitMix64& random, const std::array<double, 3>& axis,
                                            double spread) noexcept {
  const std::array<double, 3> off = random.direction();
  std::array<double, 3> n{};
  double squared = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    n[k] = axis[k] + spread * off[k];
    squared += n[k] * n[k];
  }
  for (double& component : n) component /= std::sqrt(squared);
  return n;
}

inline void start_contact_problem(QpProblem& problem) noexcept {
  problem.unknowns = 6;
  problem.rows = 0;
  for (std::size_t k = 0; k < 6; ++k) problem.weight[k] = k < 3 ? 1000.0 : 1.0;
}

/// Tool with levers up to 100 mm pressed 0.1 to 5 mm into one to three objects, -20 um to 5 mm
/// away: the problem of a sub-step (kt = 1000 N/m, kr = 1 N m/rad). One to six rows end up active.
inline void contact_problem(SplitMix64& random, int rows, QpProblem& problem) noexcept {
  start_contact_problem(problem);
  const std::array<double, 3> away = random.direction();
  const double press = random.uniform(0.1e-3, 5e-3);
  const std::array<double, 3> sideways = random.direction();
  const std::array<double, 3> turn = random.direction();
  const double angle = press / 0.05 * random.uniform();
  for (std::size_t k = 0; k < 3; ++k) {
    problem.target[k] = press * (0.3 * sideways[k] - away[k]);
    problem.target[3 + k] = angle * turn[k];
  }
  std::array<std::array<double, 3>, 3> object{};
  for (std::array<double, 3>& normal : object) normal = direction_near(random, away, 0.8);
  const std::uint64_t objects = 1 + random.below(3);
  for (int i = 0; i < rows; ++i) {
    const std::array<double, 3> n = direction_near(random, object[random.below(objects)], 0.1);
    std::array<double, 3> a = random.direction();
    const double lever = random.uniform(0.0, 0.1);
    for (double& component : a) component *= lever;
    add_row(problem, contact_row(n, a), -random.uniform(-20e-6, 5e-3));
  }
}

/// The contact problem one sub-step later: everything moves by about a hundredth.
inline void move_contacts(SplitMix64& random, QpProblem& problem) noexcept {
  for (std::size_t k = 0; k < 6; ++k) problem.target[k] *= random.uniform(0.99, 1.01);
  for (std::size_t i = 0; i < rows_of(problem); ++i) {
    for (std::size_t k = 0; k < 6; ++k) {
      problem.row[k][i] += (k < 3 ? 1e-3 : 1e-4) * random.uniform(-1.0, 1.0);
    }
    problem.bound[i] += random.uniform(-10e-6, 10e-6);
  }
}

/// Any number of unknowns, up to `most_rows` rows without structure, a third of them through one
/// point.
inline void dense_problem(SplitMix64& random, int most_rows, QpProblem& problem) noexcept {
  start_problem(random, random_count(random, 1, kMaxDenseUnknowns), problem);
  const QpVector inside = random_point(random, problem);
  const int rows = random_count(random, 0, most_rows);
  while (problem.rows < rows) {
    add_row_at(random, problem, random_row(random, problem), inside, 1.0);
  }
}

/// A tool on up to 64 strings of two unknowns each: a row has those of the tool, and of one string
/// or none; some strings have rows enough to bear on the tool alone.
inline void many_strings_problem(SplitMix64& random, QpProblem& problem) noexcept {
  const int strings = random_count(random, 1, kMaxDeflectingStrings);
  start_problem(random, kToolDof + 2 * strings, problem);
  const QpVector inside = random_point(random, problem);
  const int rows = random_count(random, 1, std::min(3 * strings, kMaxQpRows));
  while (problem.rows < rows) {
    QpVector row = random_row(random, problem);
    const int own = random_count(random, -1, strings - 1);
    for (int k = 0; k < strings; ++k) {
      if (k == own) continue;
      const std::size_t first = std::size_t{kToolDof} + 2 * static_cast<std::size_t>(k);
      row[first] = 0.0;
      row[first + 1] = 0.0;
    }
    add_row_at(random, problem, row, inside, 1.0);
  }
}

/// As dense_problem, but rows ignore the weights, so that scaled rows are dominated by the soft
/// unknowns and nearly parallel.
inline void mixed_weights_problem(SplitMix64& random, int most_rows, QpProblem& problem) noexcept {
  start_problem(random, random_count(random, 1, kMaxDenseUnknowns), problem);
  const QpVector inside = random_point(random, problem);
  const int rows = random_count(random, 0, most_rows);
  while (problem.rows < rows) {
    QpVector row{};
    for (std::size_t k = 0; k < unknowns_of(problem); ++k) row[k] = random.uniform(-1.0, 1.0);
    add_row_at(random, problem, row, inside, 1.0);
  }
}

/// Multiplies every row by its own power of two from 1e-6 to 1e6: the solution stays, bit by bit.
inline void scale_rows(SplitMix64& random, QpProblem& problem) noexcept {
  for (std::size_t i = 0; i < rows_of(problem); ++i) {
    double scale = 0x1p-20;
    for (int doubling = random_count(random, 0, 40); doubling > 0; --doubling) scale *= 2.0;
    for (std::size_t k = 0; k < unknowns_of(problem); ++k) problem.row[k][i] *= scale;
    problem.bound[i] *= scale;
  }
}

/// The same contact problem with lengths counted in `unit` metres: 1e-6 makes every length a
/// million times larger.
inline void change_length_unit(double unit, QpProblem& problem) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    problem.weight[k] *= unit * unit;
    problem.target[k] /= unit;
    for (std::size_t i = 0; i < rows_of(problem); ++i) problem.row[3 + k][i] /= unit;
  }
  for (std::size_t i = 0; i < rows_of(problem); ++i) problem.bound[i] /= unit;
}

}  // namespace hapticd::test
