// Fills, exchanges and solves the rows of one linearisation. See row_program.h. RT: yes.
#include "core/contact/row_program.h"

#include <algorithm>
#include <limits>

#include "core/contact/clearance.h"
#include "core/contact/step_admission.h"
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

/// Share of the skin that a string's vertex may take on its way to the centre of its contact.
constexpr double kCentringShare = 0.25;

/// A string that a pair already holds off may come nearer at another one by this share of the skin:
/// both legs of a string that is hardly bent are nearly one obstacle, whose pairs would be
/// exchanged for each other string by string. Larger: forces less exact, by kt times as much;
/// smaller: more iterations where many strings are met at once.
constexpr double kTwinShare = 1e-3;

/// What a row asks of the tool, and its right-hand side.
struct ToolRow {
  Vector3 linear;
  Vector3 angular;
  double bound;
};

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
void set_tool_rows(const ToolColumns& columns, const Linearisation& model,
                   QpProblem& problem) noexcept {
  const SquareMatrix& basis = model.basis();
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
  for (std::size_t k = basis.size; k < model.unknowns(); ++k) {
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
double violation(const ContactRow& row, const Unknowns& y, double& fraction,
                 double tolerance) noexcept {
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

/// Rows that may still come in, one at least. Where the strings are eliminated each costs an
/// iteration, and those are dear: no more than the budget has left beside the next program.
std::size_t affordable_rows(const ContactView& view, const Linearisation& model) noexcept {
  const auto strings = static_cast<std::int64_t>(model.eliminated().size());
  const std::int64_t budget = view.input.work_budget;
  if (budget <= 0 || strings == 0) return kMaxQpRows;
  const std::int64_t program = kStringPairWork * strings * strings;
  const std::int64_t each = kIterationWork + program / kIterationsPerFactor;
  const std::int64_t left = budget - tick_work(view.result) - program;
  return static_cast<std::size_t>(std::clamp<std::int64_t>(left / each, 1, kMaxQpRows));
}

}  // namespace

/// What the rows of one linearisation are made from.
struct RowProgram::Context {
  const ContactView& view;
  const Linearisation& model;
  double centring_room;  ///< see ConfigurationStep, m
  double clearance;      ///< that rows ask for, m
  bool regain;           ///< they ask back what their gaps lack of it

  /// What a row asks of a gap that lacks so much of the surface, m.
  [[nodiscard]] double asked(double lacking) const noexcept {
    return regain ? clearance + lacking : std::min(0.0, clearance + lacking);
  }
  /// True where no touched string and no soft part has a share in the contact: the tool alone moves
  /// it.
  [[nodiscard]] bool tool_alone(const Contact& contact) const noexcept {
    return view.state.parts.empty() && find_touched(view.state.touched, contact.key) < 0;
  }
  /// The row of a pair that the tool alone moves.
  [[nodiscard]] ToolRow tool_row(const Contact& contact) const noexcept {
    return {contact.nhat_OG_W, (contact.p_WC - view.state.X_WG.p).cross(contact.nhat_OG_W),
            asked(-contact.gap)};
  }
  [[nodiscard]] ContactRow row(const Contact& contact) const noexcept {
    ContactRow row = contact_row(view, contact);
    row.bound = asked(row.bound);
    return row;
  }
};

// Adds the `most` most violated of the first `count` in order_ to the first `kept` rows.
void RowProgram::add_worst(std::size_t kept, std::size_t most, std::size_t count) noexcept {
  const auto first = order_.begin();
  const auto last = first + static_cast<std::ptrdiff_t>(most);
  std::nth_element(first, last, first + static_cast<std::ptrdiff_t>(count),
                   [this](std::int32_t a, std::int32_t b) {
                     const double excess_a = excess_[static_cast<std::size_t>(a)];
                     const double excess_b = excess_[static_cast<std::size_t>(b)];
                     return excess_a != excess_b ? excess_a > excess_b : a < b;
                   });
  std::copy(first, last, contact_of_row_.begin() + static_cast<std::ptrdiff_t>(kept));
  problem_.rows = static_cast<int>(kept + most);
}

// Puts the first `pressed` rows in the order of their strings, in which the solver passes over most
// of what is zero.
void RowProgram::sort_by_string(const ContactSet& contacts, std::size_t pressed) noexcept {
  const auto string_of = [&contacts](std::int32_t c) {
    const ContactKey& key = contacts.contacts[static_cast<std::size_t>(c)].key;
    return is_string(key) ? key.obstacle : -1;
  };
  const auto first = contact_of_row_.begin();
  std::sort(first, first + static_cast<std::ptrdiff_t>(pressed),
            [&string_of](std::int32_t a, std::int32_t b) {
              const std::int32_t string_a = string_of(a);
              const std::int32_t string_b = string_of(b);
              return string_a != string_b ? string_a < string_b : a < b;
            });
}

// The first rows: the contacts that bore force last, then the nearest.
void RowProgram::choose_rows(const Context& context) noexcept {
  const auto& contacts = context.view.contacts.contacts;
  const ContactState& state = context.view.state;
  const auto most = static_cast<std::size_t>(context.view.input.options.max_rows);
  constexpr double kTaken = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < contacts.size(); ++c) excess_[c] = -contacts[c].gap;
  std::size_t pressed = 0;
  for (int k = 0; k < state.active_count; ++k) {
    const ContactKey& key = state.active[static_cast<std::size_t>(k)].key;
    const auto found = std::find_if(contacts.begin(), contacts.end(),
                                    [&key](const Contact& contact) { return contact.key == key; });
    if (found == contacts.end() || pressed == most) continue;
    const auto c = found - contacts.begin();
    contact_of_row_[pressed++] = static_cast<std::int32_t>(c);
    excess_[static_cast<std::size_t>(c)] = kTaken;
  }
  if (!context.model.eliminated().empty()) sort_by_string(context.view.contacts, pressed);
  std::size_t others = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (excess_[c] < kTaken) order_[others++] = static_cast<std::int32_t>(c);
  }
  const std::size_t first = std::max(std::min(kFirstRows, most), pressed);
  add_worst(pressed, std::min(others, first - pressed), others);
  pressed_ = static_cast<int>(pressed);
}

void RowProgram::fill_rows(const Context& context) noexcept {
  const auto contact_of = [&](std::size_t r) -> const Contact& {
    return context.view.contacts.contacts[static_cast<std::size_t>(contact_of_row_[r])];
  };
  ToolColumns columns;
  std::array<StringTerm, kMaxQpRows> strings;
  std::size_t string_count = 0;
  const auto rows = static_cast<std::size_t>(problem_.rows);
  for (std::size_t r = 0; r < rows; ++r) {
    if (context.tool_alone(contact_of(r))) {
      const ToolRow row = context.tool_row(contact_of(r));
      set_tool_columns(row.linear, row.angular, r, columns);
      problem_.bound[r] = row.bound;
      continue;
    }
    const ContactRow row = context.row(contact_of(r));
    set_tool_columns(row.linear, row.angular, r, columns);
    problem_.bound[r] = row.bound;
    if (row.unknown < 0) continue;
    strings[string_count++] = {r, static_cast<std::size_t>(row.unknown), row.radial,
                               row.tangential};
  }
  set_tool_rows(columns, context.model, problem_);
  for (std::size_t k = 0; k < string_count; ++k) context.model.add_string(strings[k], problem_);
  if (context.view.state.parts.empty()) return;
  for (std::size_t r = 0; r < rows; ++r) {
    const ContactRow row = context.row(contact_of(r));
    if (row.parts > 0) add_parts(row, r, context.model.basis(), problem_);
  }
}

// Of the first `violated` contacts in order_, leaves of each touched string the worst alone: where
// many strings are met at once, their other pairs mostly hold with it; none of a string that the
// solution holds off already but for a small share of the skin. Returns how many are left.
std::size_t RowProgram::keep_worst_of_strings(const ContactView& view,
                                              std::size_t violated) noexcept {
  const double twin = kTwinShare * skin_of(view.input.options);
  const auto string_of = [&view](std::int32_t c) {
    return find_touched(view.state.touched,
                        view.contacts.contacts[static_cast<std::size_t>(c)].key);
  };
  std::array<bool, kMaxDeflectingStrings> held_off;
  held_off.fill(false);
  for (int k = 0; k < solution_.active_count; ++k) {
    const auto row = static_cast<std::size_t>(solution_.active[static_cast<std::size_t>(k)]);
    const int s = string_of(contact_of_row_[row]);
    if (s >= 0) held_off[static_cast<std::size_t>(s)] = true;
  }
  std::array<std::size_t, kMaxDeflectingStrings> worst;
  worst.fill(violated);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < violated; ++k) {
    const std::int32_t c = order_[k];
    const double excess = excess_[static_cast<std::size_t>(c)];
    const int s = string_of(c);
    if (s >= 0 && held_off[static_cast<std::size_t>(s)] && excess < twin) continue;
    std::size_t* const place = s >= 0 ? &worst[static_cast<std::size_t>(s)] : nullptr;
    if (place == nullptr || *place == violated) {
      if (place != nullptr) *place = kept;
      order_[kept++] = c;
    } else if (excess > excess_[static_cast<std::size_t>(order_[*place])]) {
      order_[*place] = c;
    }
  }
  return kept;
}

// Lists in order_ the contacts that the unknowns y violate; `fraction` shrinks to what holds all.
std::size_t RowProgram::find_violated(const Context& context, const Unknowns& y,
                                      double& fraction) noexcept {
  const ContactView& view = context.view;
  const double tolerance = kRowTolerancePerMargin * view.input.options.margin;
  const ToolMotion& tool = step_.tool;
  // A contact's point goes no farther than the bound, nor does what its string slides and yields.
  const double far = context.clearance + 2.0 * step_bound(view.at(), step_);
  std::size_t violated = 0;
  for (std::size_t c = 0; c < view.contacts.contacts.size(); ++c) {
    const Contact& contact = view.contacts.contacts[c];
    if (contact.gap > far) continue;
    if (context.tool_alone(contact)) {
      const ToolRow row = context.tool_row(contact);
      excess_[c] = lacking(row.bound, row.linear.dot(tool.dp) + row.angular.dot(tool.dtheta),
                           fraction, tolerance);
    } else {
      excess_[c] = violation(context.row(contact), y, fraction, tolerance);
    }
    if (excess_[c] > tolerance) order_[violated++] = static_cast<std::int32_t>(c);
  }
  return violated;
}

// Keeps the active rows and fills up with the worst violated of all contacts. Returns the fraction
// of the step that all hold. Keeping the active rows makes the optimum grow with every exchange, so
// the rounds cannot cycle.
double RowProgram::exchange_rows(const Context& context, const Unknowns& y,
                                 ContactResult& result) noexcept {
  double fraction = 1.0;
  std::size_t violated = find_violated(context, y, fraction);
  if (violated == 0) return 1.0;
  if (!context.model.eliminated().empty()) {
    violated = keep_worst_of_strings(context.view, violated);
    if (violated == 0) return 1.0;
  }

  std::array<std::int32_t, kMaxQpUnknowns> kept;
  const auto active = static_cast<std::size_t>(solution_.active_count);
  for (std::size_t k = 0; k < active; ++k) {
    kept[k] = contact_of_row_[static_cast<std::size_t>(solution_.active[k])];
  }
  const auto most = static_cast<std::size_t>(context.view.input.options.max_rows);
  const std::size_t added =
      std::min({violated, most - active, affordable_rows(context.view, context.model)});
  std::copy_n(kept.begin(), active, contact_of_row_.begin());
  add_worst(active, added, violated);
  result.rows_exchanged += static_cast<int>(added);
  return fraction;
}

// Solves the program with the rows at hand, exchanging them until all contacts hold. Returns the
// fraction of the step that all hold.
double RowProgram::solve_rows(const Context& context, QpWarmStart warm,
                              ContactResult& result) noexcept {
  const ContactView& view = context.view;
  const auto strings = static_cast<std::int64_t>(context.model.eliminated().size());
  const std::int64_t pairs = strings * strings;
  const bool all_fit = view.contacts.contacts.size() == static_cast<std::size_t>(problem_.rows);
  for (int round = 0;; ++round) {
    solve_qp(problem_, warm, qp_, solution_);
    result.qp_iterations += solution_.iterations;
    result.string_pairs += pairs + pairs * solution_.iterations / kIterationsPerFactor;
    if (!optimal()) return 0.0;
    Unknowns y;
    context.model.find_unknowns(solution_, y);
    step_.tool = {{y[0], y[1], y[2]}, {y[3], y[4], y[5]}};
    step_.centring_room = context.centring_room;
    view.parts.read_step(view.at(), y, step_);
    view.strings.read_step(view.at(), y, step_);
    if (all_fit) return 1.0;
    // The rows of the last solution name its multipliers, so they must stay as they are once the
    // rounds are over.
    const int solved_rows = problem_.rows;
    const auto solved_contacts = contact_of_row_;
    const double fraction = exchange_rows(context, y, result);
    if (fraction >= 1.0) return 1.0;
    // Of many strings even the exchanges of one program may be more than a tick has time for.
    const bool used_up =
        strings > 0 && view.input.work_budget > 0 && tick_work(result) > view.input.work_budget;
    if (round == kMaxExchangeRounds || used_up) {
      problem_.rows = solved_rows;
      contact_of_row_ = solved_contacts;
      return fraction;
    }
    fill_rows(context);
    result.rows += problem_.rows;
    warm = first_rows(solution_.active_count);
  }
}

// The same with the first rows of a linearisation.
double RowProgram::solve_from_first(const Context& context, ContactResult& result) noexcept {
  choose_rows(context);
  fill_rows(context);
  result.rows += problem_.rows;
  return solve_rows(context, first_rows(pressed_), result);
}

void RowProgram::solve(const ContactView& view, const Linearisation& model,
                       ContactResult& result) noexcept {
  const double clearance = view.state.clearance;
  model.set_objective(problem_);
  // Once a tick: where the centre is depends on what the tool does next.
  const double centring_room =
      result.sub_steps == 1 ? kCentringShare * skin_of(view.input.options) : 0.0;
  // A clearance that is used up lets no step turn the tool. Where the obstacles on all sides leave
  // no room for it the rows contradict each other, and ask for what there is.
  if (view.contacts.minimum_gap < clearance) {
    feasible_fraction_ = solve_from_first({view, model, centring_room, clearance, true}, result);
    if (optimal()) return;
  }
  feasible_fraction_ = solve_from_first({view, model, centring_room, clearance, false}, result);
}

bool RowProgram::solve_surface(const ContactView& view, const Linearisation& model, bool arrived,
                               ContactResult& result) noexcept {
  const Context context{view, model, 0.0, 0.0, true};
  const auto rows = static_cast<std::size_t>(problem_.rows);
  for (std::size_t r = 0; r < rows; ++r) {
    problem_.bound[r] = -view.contacts.contacts[static_cast<std::size_t>(contact_of_row_[r])].gap;
  }
  if (arrived) {
    for (std::size_t k = 0; k < unknowns(); ++k) problem_.target[k] -= solution_.x[k];
  }
  QpWarmStart warm;
  for (; warm.count < solution_.active_count; ++warm.count) {
    const auto k = static_cast<std::size_t>(warm.count);
    warm.active[k] = solution_.active[k];
  }
  // Not counted as work: where forces hardly change there is next to none.
  const int iterations = result.qp_iterations;
  static_cast<void>(solve_rows(context, warm, result));
  result.qp_iterations = iterations;
  return optimal();
}

bool RowProgram::find_way_out(const Configuration& at, const ContactSet& contacts, Vector3& dp_W,
                              ContactResult& result) noexcept {
  const double skin = skin_of(at.input.options);
  problem_.unknowns = 3;
  problem_.rows = 0;
  problem_.weight.fill(1.0);
  problem_.target.fill(0.0);
  for (const Contact& contact : contacts.contacts) {
    if (problem_.rows == at.input.options.max_rows) break;
    const auto i = static_cast<std::size_t>(problem_.rows++);
    for (std::size_t k = 0; k < 3; ++k) {
      problem_.row[k][i] = contact.nhat_OG_W[static_cast<Eigen::Index>(k)];
    }
    problem_.bound[i] = contact.gap < 0.0 ? skin - contact.gap : std::min(0.0, skin - contact.gap);
  }
  solve_qp(problem_, QpWarmStart{}, qp_, solution_);
  result.qp_iterations += solution_.iterations;
  result.rows += problem_.rows;
  dp_W = {solution_.x[0], solution_.x[1], solution_.x[2]};
  return optimal();
}

void RowProgram::drop_centring(std::size_t strings) noexcept {
  for (std::size_t k = 0; k < strings; ++k) {
    StringMotion& motion = step_.strings[k];
    if (motion.centring == 0.0) continue;
    motion.dlambda -= motion.centring;
    motion.centring = 0.0;
  }
}

}  // namespace hapticd
