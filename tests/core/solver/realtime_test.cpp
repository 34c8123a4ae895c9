// The solver and the residual never touch the heap.
#include <doctest/doctest.h>

#include <cstdint>
#include <memory>

#include "core/solver/active_set.h"
#include "tests/core/solver/kkt_residual.h"
#include "tests/support/no_heap.h"
#include "tests/support/qp_families.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("a hundred thousand solves and residuals do not touch the heap") {
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(401);
  QpWarmStart warm;
  QpSolution solution;
  double residual = 0.0;
  const std::int64_t count = scaled(100'000);
  const NoHeapScope scope;
  for (std::int64_t trial = 0; trial < count; ++trial) {
    if (trial % 2 == 0) {
      contact_problem(random, random_count(random, 0, 64), *problem);
    } else {
      dense_problem(random, 40, *problem);
    }
    solve_qp(*problem, warm, *workspace, solution);
    warm.count = solution.active_count;
    warm.active = solution.active;
    residual += kkt_residual(*problem, solution);
  }
  const std::int64_t touched = scope.count();
  CHECK(touched == 0);
  CHECK(residual < 1e-9 * static_cast<double>(count));
}

}  // namespace hapticd::test
