// Fills, exchanges and solves the rows of one linearisation. See contact_rows.h. RT: yes.
#include "core/rendering/contact_rows.h"

#include <algorithm>

#include "core/rendering/local_model.h"

namespace hapticd {
namespace {

/// A row counts as violated beyond this share of the margin: rounding of the solver, far below the
/// skin.
constexpr double kRowTolerancePerMargin = 1e-9;

/// Left-hand coefficients [n; a x n] and right-hand side of one contact.
struct ContactRow {
  Vector3 linear;
  Vector3 angular;
  double bound;
};

ContactRow row_of(const Contact& contact, const Vector3& p_WG, double skin) noexcept {
  const Vector3 p_GC_W = contact.p_WC - p_WG;
  return {contact.nhat_OG_W, p_GC_W.cross(contact.nhat_OG_W), std::min(0.0, skin - contact.gap)};
}

void set_row(QpProblem& problem, int i, const ContactRow& row, const Matrix6& basis) noexcept {
  const auto r = static_cast<std::size_t>(i);
  Vector6 row_x;
  row_x << row.linear, row.angular;
  const Vector6 row_z = basis.transpose() * row_x;
  for (std::size_t k = 0; k < kToolDof; ++k)
    problem.row[k][r] = row_z[static_cast<Eigen::Index>(k)];
  problem.bound[r] = row.bound;
}

void set_objective(const LocalModel& model, QpProblem& problem) noexcept {
  problem.unknowns = kToolDof;
  for (std::size_t k = 0; k < kToolDof; ++k) {
    problem.weight[k] = 1.0;
    problem.target[k] = model.target_z[static_cast<Eigen::Index>(k)];
  }
}

/// The nearest contacts become the rows; all of them when they fit.
void choose_nearest(OptimiserWorkspace& w) noexcept {
  const auto count = static_cast<std::int32_t>(w.contacts.contacts.size());
  const auto first = w.order.begin();
  for (std::int32_t i = 0; i < count; ++i) w.order[static_cast<std::size_t>(i)] = i;
  const std::int32_t rows = std::min(count, kMaxQpRows);
  if (count > kMaxQpRows) {
    std::nth_element(first, first + rows, first + count, [&w](std::int32_t a, std::int32_t b) {
      const double gap_a = w.contacts.contacts[static_cast<std::size_t>(a)].gap;
      const double gap_b = w.contacts.contacts[static_cast<std::size_t>(b)].gap;
      return gap_a != gap_b ? gap_a < gap_b : a < b;
    });
  }
  std::copy(first, first + rows, w.contact_of_row.begin());
  w.problem.rows = rows;
}

void fill_rows(const OptimiserInput& input, const Vector3& p_WG, const Matrix6& basis,
               OptimiserWorkspace& w) noexcept {
  for (int i = 0; i < w.problem.rows; ++i) {
    const auto c = static_cast<std::size_t>(w.contact_of_row[static_cast<std::size_t>(i)]);
    set_row(w.problem, i, row_of(w.contacts.contacts[c], p_WG, input.options.skin), basis);
  }
}

/// Rows whose pair carried force last time.
QpWarmStart warm_start(const OptimiserState& state, const OptimiserWorkspace& w) noexcept {
  QpWarmStart warm;
  for (int k = 0; k < state.active_count; ++k) {
    for (int i = 0; i < w.problem.rows; ++i) {
      const auto c = static_cast<std::size_t>(w.contact_of_row[static_cast<std::size_t>(i)]);
      if (!(w.contacts.contacts[c].key == state.active[static_cast<std::size_t>(k)].key)) continue;
      warm.active[static_cast<std::size_t>(warm.count++)] = static_cast<std::int16_t>(i);
      break;
    }
  }
  return warm;
}

/// How far the step violates the row (m); <= 0 when it holds. `fraction` shrinks to what holds it.
double violation(const ContactRow& row, const ToolStep& x, double& fraction,
                 double tolerance) noexcept {
  const double moved_by = row.linear.dot(x.dp) + row.angular.dot(x.dtheta);
  const double excess = row.bound - moved_by;
  if (excess > tolerance) fraction = std::min(fraction, row.bound / moved_by);
  return excess;
}

ToolStep step_of(const QpSolution& solution, const Matrix6& basis) noexcept {
  Vector6 z;
  for (std::size_t k = 0; k < kToolDof; ++k) z[static_cast<Eigen::Index>(k)] = solution.x[k];
  const Vector6 x = basis * z;
  return {x.head<3>(), x.tail<3>()};
}

/// Keeps the active rows and fills up with the worst violated of all contacts. Returns the fraction
/// of the step that all hold. Keeping the active rows makes the optimum grow with every exchange,
/// so the rounds cannot cycle.
double exchange_rows(const OptimiserInput& input, const Vector3& p_WG, OptimiserWorkspace& w,
                     OptimiserResult& result) noexcept {
  const ToolStep& x = w.step;
  const double tolerance = kRowTolerancePerMargin * input.options.margin;
  double fraction = 1.0;
  std::size_t violated = 0;
  for (std::size_t c = 0; c < w.contacts.contacts.size(); ++c) {
    const ContactRow row = row_of(w.contacts.contacts[c], p_WG, input.options.skin);
    w.excess[c] = violation(row, x, fraction, tolerance);
    if (w.excess[c] > tolerance) w.order[violated++] = static_cast<std::int32_t>(c);
  }
  if (violated == 0) return 1.0;

  std::array<std::int32_t, kMaxQpUnknowns> kept;
  const auto active = static_cast<std::size_t>(w.solution.active_count);
  for (std::size_t k = 0; k < active; ++k) {
    kept[k] = w.contact_of_row[static_cast<std::size_t>(w.solution.active[k])];
  }
  const std::size_t added = std::min(violated, static_cast<std::size_t>(kMaxQpRows) - active);
  const auto first = w.order.begin();
  std::nth_element(first, first + static_cast<std::ptrdiff_t>(added) - 1,
                   first + static_cast<std::ptrdiff_t>(violated),
                   [&w](std::int32_t a, std::int32_t b) {
                     const double excess_a = w.excess[static_cast<std::size_t>(a)];
                     const double excess_b = w.excess[static_cast<std::size_t>(b)];
                     return excess_a != excess_b ? excess_a > excess_b : a < b;
                   });
  std::copy(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(active),
            w.contact_of_row.begin());
  std::copy(first, first + static_cast<std::ptrdiff_t>(added),
            w.contact_of_row.begin() + static_cast<std::ptrdiff_t>(active));
  w.problem.rows = static_cast<int>(active + added);
  result.rows_exchanged += static_cast<int>(added);
  return fraction;
}

}  // namespace

double solve_linearisation(const OptimiserInput& input, const OptimiserState& state,
                           const ToolStep& e, OptimiserWorkspace& w,
                           OptimiserResult& result) noexcept {
  const Vector3& p_WG = state.X_WG.p;
  const LocalModel model = local_model(input, state, e);
  set_objective(model, w.problem);
  choose_nearest(w);
  fill_rows(input, p_WG, model.basis, w);
  QpWarmStart warm = warm_start(state, w);
  const bool all_fit = w.contacts.contacts.size() <= static_cast<std::size_t>(kMaxQpRows);
  for (int round = 0;; ++round) {
    solve_qp(w.problem, warm, w.qp, w.solution);
    result.qp_iterations += w.solution.iterations;
    if (w.solution.status != QpStatus::kOptimal) return 0.0;
    w.step = step_of(w.solution, model.basis);
    if (all_fit) return 1.0;
    // The rows of the last solution name its multipliers, so they must stay as they are once the
    // rounds are over.
    const int solved_rows = w.problem.rows;
    const auto solved_contacts = w.contact_of_row;
    const double fraction = exchange_rows(input, p_WG, w, result);
    if (fraction >= 1.0) return 1.0;
    if (round == kMaxExchangeRounds) {
      w.problem.rows = solved_rows;
      w.contact_of_row = solved_contacts;
      return fraction;
    }
    fill_rows(input, p_WG, model.basis, w);
    // Active rows come first after an exchange.
    warm.count = w.solution.active_count;
    for (int k = 0; k < warm.count; ++k)
      warm.active[static_cast<std::size_t>(k)] = static_cast<std::int16_t>(k);
  }
}

}  // namespace hapticd
