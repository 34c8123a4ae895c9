// The residual on a problem whose solution and multipliers are known by hand, and on the same
// solution spoilt in each way it can be: every kind must be seen, at its size.
#include "tests/core/solver/kkt_residual.h"

#include <doctest/doctest.h>

#include <limits>

#include "tests/support/qp_families.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Known {
  QpProblem problem;
  QpSolution solution;
};

/// Corner of two walls and a far third: weights 4 and 9, target (-1, -2), x >= 0, 2 y >= 0, x >=
/// -5. In the scaled space the target is (-2, -6); the multipliers of unit rows are 2 and 6.
Known known_corner() {
  Known known;
  QpProblem& problem = known.problem;
  problem.unknowns = 2;
  problem.rows = 0;
  problem.weight[0] = 4.0;
  problem.weight[1] = 9.0;
  problem.target[0] = -1.0;
  problem.target[1] = -2.0;
  add_row(problem, {1.0, 0.0}, 0.0);
  add_row(problem, {0.0, 2.0}, 0.0);
  add_row(problem, {1.0, 0.0}, -5.0);
  QpSolution& solution = known.solution;
  solution.x[0] = 0.0;
  solution.x[1] = 0.0;
  solution.active_count = 2;
  solution.active[0] = 0;
  solution.active[1] = 1;
  solution.multiplier[0] = 4.0;
  solution.multiplier[1] = 9.0;
  return known;
}

}  // namespace

TEST_CASE("the residual of a solution known by hand is zero") {
  const Known known = known_corner();
  CHECK(kkt_residual(known.problem, known.solution) == 0.0);
}

TEST_CASE("the residual of a target that needs no row is zero") {
  Known known = known_corner();
  known.problem.target[0] = 1.0;
  known.problem.target[1] = 1.0;
  known.solution.x[0] = 1.0;
  known.solution.x[1] = 1.0;
  known.solution.active_count = 0;
  CHECK(kkt_residual(known.problem, known.solution) == 0.0);
}

TEST_CASE("the residual sees a point off the stationary one") {
  // z moves by 2 * 1e-3 along the first axis; the sum of multipliers, 8, is the measure.
  Known known = known_corner();
  known.solution.x[0] = 1e-3;
  CHECK(kkt_residual(known.problem, known.solution) == doctest::Approx(2e-3 / std::sqrt(40.0)));
  known.solution.active_count = 1;
  known.solution.multiplier[0] = 4.0;
  known.solution.x[0] = 0.0;
  CHECK(kkt_residual(known.problem, known.solution) == doctest::Approx(6.0 / std::sqrt(40.0)));
}

TEST_CASE("the residual sees a wrong multiplier at its size") {
  // 1e-3 in the multiplier of row 1 is 1e-3 * 2 / 3 in the scaled space.
  Known known = known_corner();
  known.solution.multiplier[1] += 1e-3;
  const double expected = 1e-3 * 2.0 / 3.0 / (8.0 + 1e-3 * 2.0 / 3.0);
  CHECK(kkt_residual(known.problem, known.solution) == within(expected, 1e-9));
}

TEST_CASE("the residual sees a violated row that is not active") {
  // The target itself, no active row: stationary, but both walls are violated, the second by 6.
  Known known = known_corner();
  known.solution.active_count = 0;
  known.solution.x[0] = -1.0;
  known.solution.x[1] = -2.0;
  CHECK(kkt_residual(known.problem, known.solution) == doctest::Approx(6.0 / std::sqrt(40.0)));
}

TEST_CASE("the residual sees a negative multiplier") {
  // Held at y = 0 although the target is inside: balanced only by pulling.
  Known known = known_corner();
  known.problem.target[1] = 2.0;
  known.solution.multiplier[1] = -9.0;
  CHECK(kkt_residual(known.problem, known.solution) == doctest::Approx(6.0 / std::sqrt(40.0)));
}

TEST_CASE("the residual sees a multiplier on a row with room") {
  // Row 2 (x >= -5, 10 away in the scaled space) takes over from row 0.
  Known known = known_corner();
  known.solution.active[0] = 2;
  CHECK(kkt_residual(known.problem, known.solution) == doctest::Approx(2.0 / std::sqrt(40.0)));
}

TEST_CASE("the residual of a zero row that can never hold is infinite") {
  Known known = known_corner();
  add_row(known.problem, {0.0, 0.0}, 1e-9);
  CHECK(kkt_residual(known.problem, known.solution) == kInfinity);
  known.problem.bound[3] = 0.0;
  CHECK(kkt_residual(known.problem, known.solution) == 0.0);
}

TEST_CASE("the residual of a malformed or non-finite solution is infinite") {
  Known known = known_corner();
  SUBCASE("active row outside") { known.solution.active[1] = 3; }
  SUBCASE("negative active row") { known.solution.active[1] = -1; }
  SUBCASE("more active rows than unknowns") { known.solution.active_count = 3; }
  SUBCASE("negative count") { known.solution.active_count = -1; }
  SUBCASE("x is not a number") { known.solution.x[1] = std::numeric_limits<double>::quiet_NaN(); }
  SUBCASE("multiplier is not a number") {
    known.solution.multiplier[0] = std::numeric_limits<double>::quiet_NaN();
  }
  SUBCASE("multiplier is infinite") { known.solution.multiplier[0] = kInfinity; }
  CHECK(kkt_residual(known.problem, known.solution) == kInfinity);
}

TEST_CASE("the residual does not depend on the scale of a row or the unit of length") {
  Known known = known_corner();
  known.solution.x[0] = 1e-3;
  const double before = kkt_residual(known.problem, known.solution);
  known.problem.row[1][1] *= 1e6;
  known.solution.multiplier[1] /= 1e6;
  CHECK(kkt_residual(known.problem, known.solution) == within(before, 1e-12));
  for (std::size_t k = 0; k < 2; ++k) {
    known.problem.target[k] *= 1e6;
    known.problem.weight[k] *= 1e-12;
    known.solution.x[k] *= 1e6;
    known.solution.multiplier[k] *= 1e-6;
  }
  known.problem.bound[2] *= 1e6;
  CHECK(kkt_residual(known.problem, known.solution) == within(before, 1e-12));
}

}  // namespace hapticd::test
