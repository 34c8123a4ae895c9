// Fills, exchanges and solves the rows of one linearisation. See contact_rows.h. RT: yes.
#include "core/contact/contact_rows.h"

#include <algorithm>
#include <limits>

#include "core/collision/primitive_gap.h"
#include "core/contact/local_model.h"
#include "core/contact/model_coordinates.h"
#include "core/contact/step_admission.h"
#include "core/contact/string_block.h"
#include "core/contact/string_rows.h"
#include "core/contact/tick_work.h"

namespace hapticd {
namespace {

/// A row counts as violated beyond this share of the margin: rounding of the solver, far below the
/// skin.
constexpr double kRowTolerancePerMargin = 1e-9;

/// Rows that a program begins with: of the pairs that bore force last, and of the nearest. Others
/// come in when they are violated, which changes no force. More: dearer programs where much is
/// near; fewer: more programs.
constexpr std::size_t kFirstRows = 8;

/// Iterations of a program of many strings that cost what its first rows do.
constexpr std::int64_t kIterationsPerFactor = 8;

/// Share of the skin that the way of a string's vertex to the centre of its contact may take.
constexpr double kCentringShare = 0.25;

/// What the rows of one linearisation are made from.
struct RowContext {
  const ContactInput& input;
  const ContactState& state;
  const OptimiserWorkspace& w;
  double centring_room;  ///< see string_motion, m
  bool regain;           ///< rows ask back what their gaps lack of the skin
};

/// True where no held string and no soft part has a share in the contact: the tool alone moves it.
bool tool_alone(const RowContext& context, const Contact& contact) noexcept {
  return context.state.parts.empty() && find_touched(context.state.touched, contact.key) < 0;
}

/// What a row asks of the tool, and its right-hand side.
struct ToolRow {
  Vector3 linear;
  Vector3 angular;
  double bound;
};

/// The row of a pair that the tool alone moves.
ToolRow tool_row_of(const RowContext& context, const Contact& contact) noexcept {
  const double lacking = context.input.options.skin - contact.gap;
  return {contact.nhat_OG_W, (contact.p_WC - context.state.X_WG.p).cross(contact.nhat_OG_W),
          context.regain ? lacking : std::min(0.0, lacking)};
}

ContactRow row_of(const RowContext& context, const Contact& contact) noexcept {
  ContactRow row = contact_row(context.input, context.state, context.w, contact);
  if (!context.regain) row.bound = std::min(0.0, row.bound);
  return row;
}

/// What the rows ask of the tool alone, coordinate by coordinate, so that the compiler computes
/// several rows at once.
struct ToolColumns {
  std::array<std::array<double, kMaxQpRows>, kToolDof> of;
};

void set_tool_columns(const Vector3& linear, const Vector3& angular, std::size_t r,
                      ToolColumns& columns) noexcept {
  for (std::size_t j = 0; j < 3; ++j) {
    columns.of[j][r] = linear[static_cast<Eigen::Index>(j)];
    columns.of[j + 3][r] = angular[static_cast<Eigen::Index>(j)];
  }
}

/// The rows of the problem as far as the tool alone goes; zero in the coordinates of strings that
/// are eliminated.
void set_tool_rows(const ToolColumns& columns, const LocalModel& model,
                   QpProblem& problem) noexcept {
  const SquareMatrix& basis = model.basis;
  const auto rows = static_cast<std::size_t>(problem.rows);
  for (std::size_t k = 0; k < basis.size; ++k) {
    std::array<double, kToolDof> b;
    for (std::size_t j = 0; j < b.size(); ++j) b[j] = basis(j, k);
    double* const out = problem.row[k].data();
    for (std::size_t r = 0; r < rows; ++r) {
      double sum = 0.0;
      for (std::size_t j = 0; j < b.size(); ++j) sum += b[j] * columns.of[j][r];
      out[r] = sum;
    }
  }
  for (std::size_t k = basis.size; k < model.unknowns; ++k) {
    std::fill_n(problem.row[k].begin(), rows, 0.0);
  }
}

/// Adds what row number `r` asks of soft parts.
void add_parts(const ContactRow& row, std::size_t r, const SquareMatrix& basis,
               QpProblem& problem) noexcept {
  for (std::size_t k = 0; k < basis.size; ++k) {
    double sum = problem.row[k][r];
    for (std::size_t p = 0; p < row.parts; ++p) {
      const PartTerm& part = row.part[p];
      for (std::size_t j = 0; j < 3; ++j) {
        sum += basis(part.unknown + j, k) * part.linear[static_cast<Eigen::Index>(j)];
      }
    }
    problem.row[k][r] = sum;
  }
}

/// Adds the `most` most violated of the first `count` in w.order to the first `kept` rows.
void add_worst(std::size_t kept, std::size_t most, std::size_t count,
               OptimiserWorkspace& w) noexcept {
  const auto first = w.order.begin();
  const auto last = first + static_cast<std::ptrdiff_t>(most);
  std::nth_element(first, last, first + static_cast<std::ptrdiff_t>(count),
                   [&w](std::int32_t a, std::int32_t b) {
                     const double excess_a = w.excess[static_cast<std::size_t>(a)];
                     const double excess_b = w.excess[static_cast<std::size_t>(b)];
                     return excess_a != excess_b ? excess_a > excess_b : a < b;
                   });
  std::copy(first, last, w.contact_of_row.begin() + static_cast<std::ptrdiff_t>(kept));
  w.problem.rows = static_cast<int>(kept + most);
}

/// The first rows: the contacts that bore force last, whose number it returns, then the nearest.
int choose_rows(const RowContext& context, OptimiserWorkspace& w) noexcept {
  const auto& contacts = w.contacts.contacts;
  const auto most = static_cast<std::size_t>(context.input.options.max_rows);
  constexpr double kTaken = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < contacts.size(); ++c) w.excess[c] = -contacts[c].gap;
  std::size_t pressed = 0;
  for (int k = 0; k < context.state.active_count; ++k) {
    const ContactKey& key = context.state.active[static_cast<std::size_t>(k)].key;
    const auto found = std::find_if(contacts.begin(), contacts.end(),
                                    [&key](const Contact& contact) { return contact.key == key; });
    if (found == contacts.end() || pressed == most) continue;
    const auto c = found - contacts.begin();
    w.contact_of_row[pressed++] = static_cast<std::int32_t>(c);
    w.excess[static_cast<std::size_t>(c)] = kTaken;
  }
  if (!w.model.eliminated().empty()) sort_by_string(pressed, w);
  std::size_t others = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (w.excess[c] < kTaken) w.order[others++] = static_cast<std::int32_t>(c);
  }
  const std::size_t first = std::max(std::min(kFirstRows, most), pressed);
  add_worst(pressed, std::min(others, first - pressed), others, w);
  return static_cast<int>(pressed);
}

void fill_rows(const RowContext& context, const LocalModel& model, QpProblem& problem) noexcept {
  const OptimiserWorkspace& w = context.w;
  const auto contact_of = [&w](std::size_t r) -> const Contact& {
    return w.contacts.contacts[static_cast<std::size_t>(w.contact_of_row[r])];
  };
  ToolColumns columns;
  std::array<StringTerm, kMaxQpRows> strings;
  std::size_t string_count = 0;
  const auto rows = static_cast<std::size_t>(problem.rows);
  for (std::size_t r = 0; r < rows; ++r) {
    if (tool_alone(context, contact_of(r))) {
      const ToolRow row = tool_row_of(context, contact_of(r));
      set_tool_columns(row.linear, row.angular, r, columns);
      problem.bound[r] = row.bound;
      continue;
    }
    const ContactRow row = row_of(context, contact_of(r));
    set_tool_columns(row.linear, row.angular, r, columns);
    problem.bound[r] = row.bound;
    if (row.unknown < 0) continue;
    strings[string_count++] = {r, static_cast<std::size_t>(row.unknown), row.radial,
                               row.tangential};
  }
  set_tool_rows(columns, model, problem);
  for (std::size_t k = 0; k < string_count; ++k) add_string(strings[k], model, problem);
  if (context.state.parts.empty()) return;
  for (std::size_t r = 0; r < rows; ++r) {
    const ContactRow row = row_of(context, contact_of(r));
    if (row.parts > 0) add_parts(row, r, model.basis, problem);
  }
}

/// The first `count` rows.
QpWarmStart first_rows(int count) noexcept {
  QpWarmStart warm;
  for (; warm.count < count; ++warm.count) {
    warm.active[static_cast<std::size_t>(warm.count)] = static_cast<std::int16_t>(warm.count);
  }
  return warm;
}

/// What is lacking after the row has been moved by `moved_by`, m; `fraction` shrinks to what holds
/// it.
double lacking(double bound, double moved_by, double& fraction, double tolerance) noexcept {
  // What skin is not won back shortens no step: only what closes the gap does.
  const double room = std::min(0.0, bound);
  if (room - moved_by > tolerance) fraction = std::min(fraction, room / moved_by);
  return bound - moved_by;
}

/// How far the unknowns y violate the row (m); <= 0 when it holds. `fraction` shrinks to what holds
/// it.
double violation(const ContactRow& row, const std::array<double, kMaxQpUnknowns>& y,
                 double& fraction, double tolerance) noexcept {
  double moved_by =
      row.linear.dot(Vector3(y[0], y[1], y[2])) + row.angular.dot(Vector3(y[3], y[4], y[5]));
  if (row.unknown >= 0) {
    const auto u = static_cast<std::size_t>(row.unknown);
    moved_by += row.radial * y[u] + row.tangential * y[u + 1];
  }
  for (std::size_t p = 0; p < row.parts; ++p) {
    const std::size_t v = row.part[p].unknown;
    moved_by += row.part[p].linear.dot(Vector3(y[v], y[v + 1], y[v + 2]));
  }
  return lacking(row.bound, moved_by, fraction, tolerance);
}

/// The step of the configuration that the unknowns mean.
ConfigurationStep step_of(const RowContext& context,
                          const std::array<double, kMaxQpUnknowns>& y) noexcept {
  const ContactState& state = context.state;
  ConfigurationStep step;
  step.tool = {{y[0], y[1], y[2]}, {y[3], y[4], y[5]}};
  if (!state.parts.empty()) {
    const Matrix3 R_GW = rotation_matrix(state.X_WG.q).transpose();
    for (std::size_t k = 0; k < state.parts.size(); ++k) {
      Vector3 dv_W = Vector3::Zero();
      if (const int unknown = context.w.parts[k].unknown; unknown >= 0) {
        const auto v = static_cast<std::size_t>(unknown);
        dv_W = Vector3(y[v], y[v + 1], y[v + 2]);
      }
      step.parts[k] = {dv_W, rotate(R_GW, dv_W)};
    }
  }
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const StringBlock& hold = context.w.models[k];
    if (hold.unknown < 0) {
      step.strings[k] = {Vector3::Zero(), 0.0, 0.0};
      continue;
    }
    const auto u = static_cast<std::size_t>(hold.unknown);
    const Vector3 du_W = y[u] * hold.radial_W + y[u + 1] * hold.tangential_W;
    step.strings[k] = string_motion(hold, state.touched[k].bend, step, du_W, context.centring_room);
  }
  return step;
}

/// Rows that may still come in, one at least. Where the strings are eliminated each costs an
/// iteration, and those are dear: no more than the budget has left beside the next program.
std::size_t affordable_rows(const ContactInput& input, const OptimiserWorkspace& w,
                            const ContactResult& result) noexcept {
  const auto strings = static_cast<std::int64_t>(w.model.eliminated().size());
  if (input.work_budget <= 0 || strings == 0) return kMaxQpRows;
  const std::int64_t program = kStringPairWork * strings * strings;
  const std::int64_t each = kIterationWork + program / kIterationsPerFactor;
  const std::int64_t left = input.work_budget - tick_work(result) - program;
  return static_cast<std::size_t>(std::clamp<std::int64_t>(left / each, 1, kMaxQpRows));
}

/// Keeps the active rows and fills up with the worst violated of all contacts. Returns the fraction
/// of the step that all hold. Keeping the active rows makes the optimum grow with every exchange,
/// so the rounds cannot cycle.
double exchange_rows(const RowContext& context, const std::array<double, kMaxQpUnknowns>& y,
                     OptimiserWorkspace& w, ContactResult& result) noexcept {
  const ContactInput& input = context.input;
  const double tolerance = kRowTolerancePerMargin * input.options.margin;
  const ToolMotion& tool = w.step.tool;
  // A contact's point goes no farther than the bound, nor does what its string slides and yields.
  const double far = input.options.skin + 2.0 * step_bound(input, context.state, w.step);
  double fraction = 1.0;
  std::size_t violated = 0;
  for (std::size_t c = 0; c < w.contacts.contacts.size(); ++c) {
    const Contact& contact = w.contacts.contacts[c];
    if (contact.gap > far) continue;
    if (tool_alone(context, contact)) {
      const ToolRow row = tool_row_of(context, contact);
      w.excess[c] = lacking(row.bound, row.linear.dot(tool.dp) + row.angular.dot(tool.dtheta),
                            fraction, tolerance);
    } else {
      w.excess[c] = violation(row_of(context, contact), y, fraction, tolerance);
    }
    if (w.excess[c] > tolerance) w.order[violated++] = static_cast<std::int32_t>(c);
  }
  if (violated == 0) return 1.0;
  if (!w.model.eliminated().empty()) {
    violated = keep_worst_of_strings(context.state, input.options.skin, violated, w);
    if (violated == 0) return 1.0;
  }

  std::array<std::int32_t, kMaxQpUnknowns> kept;
  const auto active = static_cast<std::size_t>(w.solution.active_count);
  for (std::size_t k = 0; k < active; ++k) {
    kept[k] = w.contact_of_row[static_cast<std::size_t>(w.solution.active[k])];
  }
  const std::size_t added =
      std::min({violated, static_cast<std::size_t>(input.options.max_rows) - active,
                affordable_rows(input, w, result)});
  std::copy_n(kept.begin(), active, w.contact_of_row.begin());
  add_worst(active, added, violated, w);
  result.rows_exchanged += static_cast<int>(added);
  return fraction;
}

/// Solves the program with few rows, exchanging them until all contacts hold. Returns the fraction
/// of the step that all hold.
double solve_rows(const RowContext& context, OptimiserWorkspace& w,
                  ContactResult& result) noexcept {
  const LocalModel& model = w.model;
  QpWarmStart warm = first_rows(choose_rows(context, w));
  fill_rows(context, model, w.problem);
  const auto strings = static_cast<std::int64_t>(model.eliminated().size());
  const std::int64_t pairs = strings * strings;
  const bool all_fit = w.contacts.contacts.size() == static_cast<std::size_t>(w.problem.rows);
  for (int round = 0;; ++round) {
    solve_qp(w.problem, warm, w.qp, w.solution);
    result.qp_iterations += w.solution.iterations;
    result.rows += w.problem.rows;
    result.string_pairs += pairs + pairs * w.solution.iterations / kIterationsPerFactor;
    if (w.solution.status != QpStatus::kOptimal) return 0.0;
    std::array<double, kMaxQpUnknowns> y;
    find_unknowns(w.solution, model, y);
    w.step = step_of(context, y);
    if (all_fit) return 1.0;
    // The rows of the last solution name its multipliers, so they must stay as they are once the
    // rounds are over.
    const int solved_rows = w.problem.rows;
    const auto solved_contacts = w.contact_of_row;
    const double fraction = exchange_rows(context, y, w, result);
    if (fraction >= 1.0) return 1.0;
    // Of many strings even the exchanges of one program may be more than a tick has time for.
    const bool used_up = strings > 0 && context.input.work_budget > 0 &&
                         tick_work(result) > context.input.work_budget;
    if (round == kMaxExchangeRounds || used_up) {
      w.problem.rows = solved_rows;
      w.contact_of_row = solved_contacts;
      return fraction;
    }
    fill_rows(context, model, w.problem);
    warm = first_rows(w.solution.active_count);
  }
}

}  // namespace

ContactRow contact_row(const ContactInput& input, const ContactState& state,
                       const OptimiserWorkspace& w, const Contact& contact) noexcept {
  const GapGradient gradient = gap_gradient(state, w.models, contact);
  ContactRow row;
  row.linear = gradient.linear;
  row.angular = gradient.angular;
  row.bound = input.options.skin - contact.gap;
  if (gradient.hold >= 0) {
    const StringBlock& hold = w.models[static_cast<std::size_t>(gradient.hold)];
    if (hold.unknown >= 0) {
      const StringBend& bend = state.touched[static_cast<std::size_t>(gradient.hold)].bend;
      const double share = deflection_share(bend, contact.lambda);
      row.unknown = hold.unknown;
      row.radial = -share * contact.nhat_OG_W.dot(hold.radial_W);
      row.tangential = -share * contact.nhat_OG_W.dot(hold.tangential_W);
    }
  }
  const int own = find_part(input.parts, state.parts, contact.key.tool_sphere);
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    const int unknown = w.parts[k].unknown;
    const bool is_own = own == static_cast<int>(k);
    if (unknown < 0 || (!is_own && gradient.slid == 0.0)) continue;
    row.part[row.parts++] = {static_cast<std::size_t>(unknown),
                             part_gradient(w.models, contact, gradient, k, is_own)};
  }
  return row;
}

double solve_linearisation(const ContactInput& input, const ContactState& state,
                           const PoseError& error_GH, OptimiserWorkspace& w,
                           ContactResult& result) noexcept {
  int unknowns = kToolDof;
  if (!state.parts.empty()) {
    unknowns = model_parts(input.parts, rotation_matrix(state.X_WG.q), input.stiffness.kt, input.dt,
                           state.parts, unknowns, w.parts);
  }
  if (!state.touched.empty())
    unknowns = model_strings(input, w.contacts, state, unknowns, w.models);
  build_local_model(input, state, error_GH, w.models, w.parts, unknowns, w.model);
  set_objective(w.model, w.problem);
  // Once a tick: where the centre is depends on what the tool does next.
  const double centring_room = result.sub_steps == 1 ? kCentringShare * input.options.skin : 0.0;
  // A skin that is used up lets no step turn the tool. Where the obstacles on all sides leave no
  // room for it the rows contradict each other, and ask for what there is.
  if (w.contacts.minimum_gap < input.options.skin) {
    const double fraction = solve_rows({input, state, w, centring_room, true}, w, result);
    if (w.solution.status == QpStatus::kOptimal) return fraction;
  }
  return solve_rows({input, state, w, centring_room, false}, w, result);
}

}  // namespace hapticd
