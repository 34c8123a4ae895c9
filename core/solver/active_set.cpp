// The method, in the scaled space with unit rows. Between iterations the multipliers u of the
// active rows N are >= 0 and z = z_target + N u is the projection onto their planes. An iteration
// takes the most violated row p and raises its multiplier until p holds. On the way the multipliers
// of N fall by `combination`; one that reaches zero leaves (a partial step). The dual objective
// grows with every row added, so no set of active rows comes twice.
#include "core/solver/active_set.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include "core/math/assert.h"
#include "core/solver/point_refinement.h"

namespace hapticd {
namespace {

enum class Outcome { kContinue, kOptimal, kInfeasible, kIterationLimit, kInvalid };

/// Column whose multiplier is the first to reach zero, and the step at which it does.
struct Blocking {
  std::size_t column = kMaxQpUnknowns;
  double step = std::numeric_limits<double>::infinity();
};

constexpr double kMax = std::numeric_limits<double>::max();

/// Length in the scaled space up to which a row counts as zero (the square of a shorter one loses
/// digits).
constexpr double kZeroRow = 1e-140;

/// Distance of the point from an active plane, relative to the size of the problem, that rounding
/// explains. Normal: 1e-16. Larger: violated rows are ignored, and at the end called contradictory.
/// Smaller: rounding is called a contradiction.
constexpr double kPlaneRounding = 4e-15;

/// Violation, relative like kPlaneRounding, beyond which a row ignored as rounding makes the
/// problem infeasible after all. Normal: 1e-16. Larger: worse points are called optimal. Smaller:
/// rounding of the data is called a contradiction.
constexpr double kContradiction = 1e-10;

/// Share of the greatest multiplier up to which a negative one is rounding of 0. Normal: 1e-16.
/// Larger: forces out of balance by as much. Smaller: another iteration for nothing.
constexpr double kPullRounding = 1e-12;

/// N, or the unknowns of the problem where N = 0: the rigid tool's six are known to the compiler.
template <std::size_t N>
std::size_t unknowns_of(const QpProblem& problem) noexcept {
  return N > 0 ? N : static_cast<std::size_t>(problem.unknowns);
}

std::size_t rows_of(const QpProblem& problem) noexcept {
  return static_cast<std::size_t>(problem.rows);
}

int limit_of(const QpProblem& problem) noexcept {
  return kQpIterationsPerRow * problem.rows + problem.unknowns;
}

/// False when a weight or target is not usable.
template <std::size_t N, std::size_t P>
bool prepare(const QpProblem& problem, QpWorkspace& workspace) noexcept {
  set_zero<P>(workspace.target);
  double size = 0.0;
  double poison = 0.0;
  for (std::size_t k = 0; k < unknowns_of<N>(problem); ++k) {
    const double root = std::sqrt(problem.weight[k]);
    const double inverse = 1.0 / root;
    const double z = root * problem.target[k];
    workspace.inverse_root_weight[k] = inverse;
    workspace.target.set(k, z);
    // Not a number when z is not finite, the weight not positive, or either overflows.
    poison += (inverse + z) * 0.0;
    size = std::fabs(z) > size ? std::fabs(z) : size;
  }
  workspace.target_size = size;
  workspace.lengths_known = false;
  workspace.rows_ignored = false;
  clear<P>(workspace.factor);
  return poison == 0.0;
}

/// The row as a unit normal in the scaled space; false when it is zero or not finite.
template <std::size_t N, std::size_t P>
bool make_unit_row(const QpProblem& problem, const QpWorkspace& workspace, std::size_t index,
                   UnitRow& unit) noexcept {
  set_zero<P>(unit.normal);
  for (std::size_t k = 0; k < unknowns_of<N>(problem); ++k) {
    unit.normal.set(k, problem.row[k][index] * workspace.inverse_root_weight[k]);
  }
  const double squared = dot<P>(unit.normal, unit.normal);
  if (!(squared > kZeroRow * kZeroRow && squared <= kMax)) return false;
  unit.scale = 1.0 / std::sqrt(squared);
  scale<P>(unit.normal, unit.scale, unit.normal);
  unit.offset = problem.bound[index] * unit.scale - dot<P>(unit.normal, workspace.target);
  unit.index = index;
  return true;
}

template <std::size_t N>
void write_point(const QpProblem& problem, const QpWorkspace& workspace,
                 QpSolution& solution) noexcept {
  for (std::size_t k = 0; k < unknowns_of<N>(problem); ++k) {
    solution.x[k] = problem.target[k] + workspace.factor.step[k] * workspace.inverse_root_weight[k];
  }
}

/// Size of the numbers that are rounded: largest entry of the target and of the step, scaled.
double size_of(const QpWorkspace& workspace) noexcept {
  double size = 0.0;
  for (std::size_t j = 0; j < workspace.factor.count; ++j) {
    const double coordinate = std::fabs(workspace.factor.coordinate[j]);
    size = coordinate > size ? coordinate : size;
  }
  return workspace.target_size + size;
}

/// What rows may lack by rounding alone does not count.
RowMeasure rounding_measure(const QpWorkspace& workspace) noexcept {
  return {workspace.inverse_length, kQpRounding * size_of(workspace)};
}

/// What the split row, a combination of active ones, may lack by their rounding alone.
double amplified_rounding(const QpWorkspace& workspace) noexcept {
  const double amplification = std::sqrt(workspace.split.amplification_squared);
  return kPlaneRounding * amplification * size_of(workspace);
}

/// Column of the most negative multiplier, or kMaxQpUnknowns.
std::size_t find_negative_multiplier(const ActiveFactor& factor) noexcept {
  std::size_t column = kMaxQpUnknowns;
  double least = 0.0;
  for (std::size_t j = 0; j < factor.count; ++j) {
    if (factor.multiplier[j] < least) {
      least = factor.multiplier[j];
      column = j;
    }
  }
  return column;
}

/// Takes a column out of the active set. Rows that lay within the rounding of the old set count
/// again.
template <std::size_t P>
void drop(QpWorkspace& workspace, std::size_t column) noexcept {
  remove<P>(workspace.factor, column);
  if (workspace.rows_ignored) workspace.lengths_known = false;
  workspace.rows_ignored = false;
}

/// Leaves out rows that the target pushes away from, worst first; of many strings all at once, for
/// as many may be let go of together.
template <std::size_t P>
void drop_negative_multipliers(QpWorkspace& workspace) noexcept {
  if constexpr (P > kMaxDense) {
    while (remove_negative<P>(workspace.factor)) {
      if (workspace.rows_ignored) workspace.lengths_known = false;
      workspace.rows_ignored = false;
    }
    return;
  }
  for (;;) {
    const std::size_t column = find_negative_multiplier(workspace.factor);
    if (column == kMaxQpUnknowns) break;
    drop<P>(workspace, column);
  }
}

/// Counts a row as satisfied while the active rows are the same or more.
void ignore_row(QpWorkspace& workspace, std::size_t index) noexcept {
  workspace.inverse_length.value[index] = 0.0;
  workspace.rows_ignored = true;
}

/// Factors the rows guessed active. Leaves out dependent rows, and rows that the target pushes
/// away from, worst first.
template <std::size_t N, std::size_t P>
void load_warm_rows(const QpProblem& problem, const QpWarmStart& warm,
                    QpWorkspace& workspace) noexcept {
  ActiveFactor& factor = workspace.factor;
  for (std::size_t j = 0; j < kMaxQpUnknowns; ++j) {
    if (static_cast<int>(j) >= warm.count || factor.count == unknowns_of<N>(problem)) break;
    if (warm.active[j] < 0 || warm.active[j] >= problem.rows) continue;
    const auto index = static_cast<std::size_t>(warm.active[j]);
    if (!make_unit_row<N, P>(problem, workspace, index, workspace.candidate)) continue;
    split_row<P>(factor, workspace.candidate.normal, workspace.split);
    if (is_dependent(workspace.split)) continue;
    append<P>(factor, workspace.candidate, workspace.split);
  }
  drop_negative_multipliers<P>(workspace);
}

Blocking find_blocking(const QpWorkspace& workspace) noexcept {
  const ActiveFactor& factor = workspace.factor;
  Blocking blocking;
  const double rounding = kQpRounding * kQpRounding * workspace.split.amplification_squared;
  for (std::size_t j = 0; j < factor.count; ++j) {
    const double rate = workspace.split.combination[j];
    if (rate <= 0.0 || rate * rate <= rounding) continue;
    const double multiplier = workspace.multiplier[j];
    const double step = multiplier > 0.0 ? multiplier / rate : 0.0;
    const bool earlier_row = step == blocking.step && blocking.column != kMaxQpUnknowns &&
                             factor.row[j].index < factor.row[blocking.column].index;
    if (step < blocking.step || earlier_row) blocking = {j, step};
  }
  return blocking;
}

/// Takes the blocking column out of the active set after a partial step.
template <std::size_t P>
void leave(QpWorkspace& workspace, const Blocking& blocking) noexcept {
  add_scaled<P>(workspace.multiplier, -blocking.step, workspace.split.combination);
  for (std::size_t j = blocking.column; j + 1 < workspace.factor.count; ++j) {
    workspace.multiplier.set(j, workspace.multiplier[j + 1]);
  }
  drop<P>(workspace, blocking.column);
}

/// Makes the candidate, violated by `violation` > 0, active.
template <std::size_t N, std::size_t P>
Outcome add_candidate(const QpProblem& problem, QpWorkspace& workspace, double violation,
                      int& iterations) noexcept {
  ActiveFactor& factor = workspace.factor;
  SplitRow& split = workspace.split;
  copy<P>(factor.multiplier, workspace.multiplier);
  const int limit = limit_of(problem);
  while (iterations < limit) {
    ++iterations;
    split_row<P>(factor, workspace.candidate.normal, split);
    const bool dependent = factor.count == unknowns_of<N>(problem) || is_dependent(split);
    if (dependent && violation <= amplified_rounding(workspace)) {
      ignore_row(workspace, workspace.candidate.index);
      return Outcome::kContinue;
    }
    const Blocking blocking = find_blocking(workspace);
    const double gain = split.rest_squared;
    if (!dependent && violation <= blocking.step * gain) {
      append<P>(factor, workspace.candidate, split);
      return Outcome::kContinue;
    }
    if (blocking.column == kMaxQpUnknowns) return Outcome::kInfeasible;
    if (!dependent) violation -= blocking.step * gain;
    leave<P>(workspace, blocking);
  }
  return Outcome::kIterationLimit;
}

/// The row to add next, kMaxQpRows when all rows hold; false when data are not finite. The first
/// look just counts: a warm start is mostly right, and needs no sizes of rows.
bool find_violated(const QpProblem& problem, const QpSolution& solution, QpWorkspace& workspace,
                   RowIndex& index) noexcept {
  const ActiveFactor& factor = workspace.factor;
  RowValues& violation = workspace.violation;
  if (workspace.lengths_known) {
    index =
        evaluate_most_violated(problem, solution.x.data(), rounding_measure(workspace), violation);
  } else {
    RowSurvey survey = evaluate_violations(problem, solution.x.data(), violation);
    if (!survey.finite) return false;
    for (std::size_t j = 0; j < factor.count; ++j) {
      if (violation.value[factor.row[j].index] > 0.0) --survey.positive;
    }
    index = kMaxQpRows;
    if (survey.positive == 0) return true;
    const double* scale = workspace.inverse_root_weight.data();
    if (!inverse_row_lengths(problem, scale, workspace.inverse_length)) return false;
    workspace.lengths_known = true;
    index = most_violated(violation, rounding_measure(workspace), rows_of(problem));
  }
  return true;
}

/// Takes a row out that pulls, by more than rounding, once the point is exact: of rows that are
/// nearly the same, rounding decides which of them push. Otherwise the clamped rest would not
/// balance.
template <std::size_t P>
bool drop_pulling_row(QpWorkspace& workspace) noexcept {
  const ActiveFactor& factor = workspace.factor;
  const std::size_t column = find_negative_multiplier(factor);
  if (column == kMaxQpUnknowns) return false;
  double greatest = 0.0;
  for (std::size_t j = 0; j < factor.count; ++j) {
    greatest = factor.multiplier[j] > greatest ? factor.multiplier[j] : greatest;
  }
  if (-factor.multiplier[column] <= kPullRounding * greatest) return false;
  drop<P>(workspace, column);
  drop_negative_multipliers<P>(workspace);
  return true;
}

/// No row is left to add: corrects the point, and looks whether rounding was indeed all that
/// ignored rows lacked.
template <std::size_t N, std::size_t P>
Outcome finish(const QpProblem& problem, QpWorkspace& workspace, QpSolution& solution) noexcept {
  refine_point<P>(problem, unknowns_of<N>(problem), workspace, solution.x);
  if (workspace.factor.sharpness > kQpSharpWedge && solution.iterations < limit_of(problem) &&
      drop_pulling_row<P>(workspace)) {
    ++solution.iterations;
    return Outcome::kContinue;
  }
  if (!workspace.rows_ignored) return Outcome::kOptimal;
  const double* scale = workspace.inverse_root_weight.data();
  if (!inverse_row_lengths(problem, scale, workspace.inverse_length)) return Outcome::kInvalid;
  const double tolerance = kContradiction * size_of(workspace);
  const RowIndex index = evaluate_most_violated(
      problem, solution.x.data(), {workspace.inverse_length, tolerance}, workspace.violation);
  if (index == kMaxQpRows) return Outcome::kOptimal;
  solution.infeasible_row = static_cast<int>(index);
  return Outcome::kInfeasible;
}

/// One iteration of the method.
template <std::size_t N, std::size_t P>
Outcome improve(const QpProblem& problem, QpWorkspace& workspace, QpSolution& solution) noexcept {
  write_point<N>(problem, workspace, solution);
  RowIndex index = kMaxQpRows;
  if (!find_violated(problem, solution, workspace, index)) return Outcome::kInvalid;
  if (index == kMaxQpRows) return finish<N, P>(problem, workspace, solution);
  UnitRow& candidate = workspace.candidate;
  if (!make_unit_row<N, P>(problem, workspace, index, candidate)) {
    solution.infeasible_row = static_cast<int>(index);
    return Outcome::kInfeasible;
  }
  const double violation = candidate.offset - dot<P>(candidate.normal, workspace.factor.step);
  const Outcome outcome = add_candidate<N, P>(problem, workspace, violation, solution.iterations);
  if (outcome == Outcome::kInfeasible) solution.infeasible_row = static_cast<int>(index);
  return outcome;
}

void write_active(const QpWorkspace& workspace, QpSolution& solution) noexcept {
  const ActiveFactor& factor = workspace.factor;
  solution.active_count = static_cast<int>(factor.count);
  for (std::size_t j = 0; j < factor.count; ++j) {
    const double multiplier = factor.multiplier[j] > 0.0 ? factor.multiplier[j] : 0.0;
    solution.active[j] = static_cast<std::int16_t>(factor.row[j].index);
    solution.multiplier[j] = multiplier * factor.row[j].scale;
  }
}

QpStatus status_of(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::kOptimal:
      return QpStatus::kOptimal;
    case Outcome::kInfeasible:
      return QpStatus::kInfeasible;
    case Outcome::kContinue:
    case Outcome::kIterationLimit:
      return QpStatus::kIterationLimit;
    case Outcome::kInvalid:
      break;
  }
  return QpStatus::kInvalid;
}

template <std::size_t N, std::size_t P>
void solve(const QpProblem& problem, const QpWarmStart& warm, QpWorkspace& workspace,
           QpSolution& solution) noexcept {
  if (!prepare<N, P>(problem, workspace)) return;
  load_warm_rows<N, P>(problem, warm, workspace);
  Outcome outcome = Outcome::kContinue;
  while (outcome == Outcome::kContinue) outcome = improve<N, P>(problem, workspace, solution);
  solution.status = status_of(outcome);
  if (outcome != Outcome::kInvalid) write_active(workspace, solution);
}

}  // namespace

void solve_qp(const QpProblem& problem, const QpWarmStart& warm, QpWorkspace& workspace,
              QpSolution& solution) noexcept {
  HD_ASSERT(problem.unknowns >= 1 && problem.unknowns <= kMaxQpUnknowns);
  HD_ASSERT(problem.rows >= 0 && problem.rows <= kMaxQpRows);
  solution.status = QpStatus::kInvalid;
  solution.active_count = 0;
  solution.iterations = 0;
  solution.infeasible_row = -1;
  if (problem.unknowns == kToolDof) {
    solve<kToolDof, kToolDof>(problem, warm, workspace, solution);
  } else if (problem.unknowns <= 8) {
    solve<0, 8>(problem, warm, workspace, solution);
  } else if (problem.unknowns <= 16) {
    solve<0, 16>(problem, warm, workspace, solution);
  } else if (problem.unknowns <= 22) {
    solve<0, 22>(problem, warm, workspace, solution);
  } else if (problem.unknowns <= 38) {
    solve<0, 38>(problem, warm, workspace, solution);
  } else if (problem.unknowns <= 54) {
    solve<0, 54>(problem, warm, workspace, solution);
  } else if (problem.unknowns <= 86) {
    solve<0, 86>(problem, warm, workspace, solution);
  } else {
    solve<0, 2 * kQpPairs>(problem, warm, workspace, solution);
  }
}

}  // namespace hapticd
