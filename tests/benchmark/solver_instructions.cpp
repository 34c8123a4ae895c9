// Solves the benchmark's problems once, in a function whose instructions callgrind counts; run by
// tests/benchmark/count_instructions. usage: solver_instructions ROWS cold|warm
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/benchmark/solver_workload.h"

namespace hapticd::test {

constexpr std::size_t kProblems = 512;

/// Callgrind collects between its entry and its return.
[[gnu::noinline]] void counted_solves(SolverWorkload& workload) {
  for (std::size_t i = 0; i < kProblems; ++i) workload.solve(i);
}

}  // namespace hapticd::test

int main(int argc, char** argv) {
  const int rows = argc == 3 ? std::atoi(argv[1]) : 0;
  if (rows < 1 || rows > hapticd::kMaxQpRows) {
    std::fprintf(stderr, "usage: solver_instructions ROWS cold|warm\n");
    return 2;
  }
  const auto workload = hapticd::test::make_solver_workload(hapticd::test::kProblems, rows,
                                                            std::strcmp(argv[2], "warm") == 0);
  hapticd::test::counted_solves(*workload);
  std::printf("%zu solves\n", hapticd::test::kProblems);
  return 0;
}
