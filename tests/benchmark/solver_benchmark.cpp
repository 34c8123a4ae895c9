// Solver of the quadratic program, cold and warm, for 1 to 256 contact rows of a rigid tool.
// Time of the benchmark: mean per solve over 64 problems, which stay in the second-level cache as
// the one the contact problem has just written does. Counters: p50_ns and p99.9_ns of single solves
// (their clock reading included, about 25 ns), iterations and active rows per solve. Instructions
// per solve: tests/benchmark/count_instructions.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#include "tests/benchmark/solver_workload.h"

namespace hapticd::test {
namespace {

constexpr std::size_t kProblems = 64;
constexpr std::size_t kTimedSolves = 100'000;

void add_counters(benchmark::State& state, SolverWorkload& workload) {
  double iterations = 0.0;
  double active = 0.0;
  for (std::size_t i = 0; i < kProblems; ++i) {
    workload.solve(i);
    iterations += workload.solution.iterations;
    active += workload.solution.active_count;
  }
  std::vector<std::int64_t> elapsed(kTimedSolves);
  for (std::size_t i = 0; i < kTimedSolves; ++i) {
    const auto start = std::chrono::steady_clock::now();
    workload.solve(i);
    elapsed[i] = std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count();
  }
  std::sort(elapsed.begin(), elapsed.end());
  state.counters["p50_ns"] = static_cast<double>(elapsed[kTimedSolves / 2]);
  state.counters["p99.9_ns"] = static_cast<double>(elapsed[kTimedSolves * 999 / 1000]);
  state.counters["iterations"] = iterations / static_cast<double>(kProblems);
  state.counters["active"] = active / static_cast<double>(kProblems);
}

void solve_contacts(benchmark::State& state, bool warm) {
  const auto workload = make_solver_workload(kProblems, static_cast<int>(state.range(0)), warm);
  std::size_t i = 0;
  for (auto _ : state) {
    workload->solve(i++);
    benchmark::DoNotOptimize(workload->solution);
  }
  add_counters(state, *workload);
}

void qp_cold(benchmark::State& state) { solve_contacts(state, false); }
void qp_warm(benchmark::State& state) { solve_contacts(state, true); }

BENCHMARK(qp_cold)->RangeMultiplier(4)->Range(1, kMaxQpRows);
BENCHMARK(qp_warm)->RangeMultiplier(4)->Range(1, kMaxQpRows);

}  // namespace
}  // namespace hapticd::test
