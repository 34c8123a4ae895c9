// From contacts to rows of the quadratic program, and its solution:
//   n . dp + (a x n) . dtheta >= clearance - gap,
// a the lever arm from the origin of G to the contact point, or >= min(0, clearance - gap) where
// obstacles leave no room for the clearance (clearance.h); a string that yields takes its share of
// the deflections with it, - share n . du, and its vertex slides along with the centre of its
// contact. A program begins with few rows, those of the pairs that bore force last and of the
// nearest, and rows are exchanged until no pair left out is violated. RT: yes; 0.9 MB, whose
// contents mean nothing between ticks.
#pragma once

#include <array>
#include <cstdint>

#include "core/contact/contact_view.h"
#include "core/contact/linearisation.h"
#include "core/contact/program_residual.h"
#include "core/solver/active_set.h"

namespace hapticd {

/// Exchange rounds at most; normal 0. When used up, the step is shortened instead (safe, slower).
inline constexpr int kMaxExchangeRounds = 8;

/// The rows chosen for one linearisation, and what they allow.
class RowProgram {
 public:
  /// Solves the program of `model` with the full target over ALL contacts of the view; counts in
  /// `result`, that of the view.
  HD_REALTIME void solve(const ContactView& view, const Linearisation& model,
                         ContactResult& result) noexcept;

  /// Solves the last program anew with the surfaces themselves, gap 0: its multipliers are the
  /// forces of the exact shapes, to first order in the clearance. `arrived`: the contacts of the
  /// view are those of the end of the last full step, not of its start. False when the solver found
  /// no optimum. Cost: about that of the program alone, 1 us.
  [[nodiscard]] HD_REALTIME bool solve_surface(const ContactView& view, const Linearisation& model,
                                               bool arrived, ContactResult& result) noexcept;

  /// Finds the shortest translation that clears every penetrated pair to first order and keeps the
  /// others. Returns false when there is none.
  [[nodiscard]] HD_REALTIME bool find_way_out(const Configuration& at, const ContactSet& contacts,
                                              Vector3& dp_W, ContactResult& result) noexcept;

  /// False when the solver found no optimum; then nothing but this means anything.
  [[nodiscard]] bool optimal() const noexcept { return solution_.status == QpStatus::kOptimal; }
  /// The full step.
  [[nodiscard]] const ConfigurationStep& step() const noexcept { return step_; }
  /// Share of it that satisfies every row, those left out included: 1 normally, 0 when the solver
  /// failed.
  [[nodiscard]] double feasible_fraction() const noexcept { return feasible_fraction_; }
  /// Unknowns of the program.
  [[nodiscard]] std::size_t unknowns() const noexcept {
    return static_cast<std::size_t>(problem_.unknowns);
  }
  /// Rows that bear force, and of each in turn: its contact with its multiplier (N), and what its
  /// gap was to gain (m).
  [[nodiscard]] int active_count() const noexcept { return solution_.active_count; }
  [[nodiscard]] ActiveContact active(int k) const noexcept {
    const auto i = static_cast<std::size_t>(k);
    return {contact_of_row_[static_cast<std::size_t>(solution_.active[i])],
            solution_.multiplier[i]};
  }
  [[nodiscard]] double wanted_gain(int k) const noexcept {
    return problem_.bound[static_cast<std::size_t>(solution_.active[static_cast<std::size_t>(k)])];
  }

  /// How far the last solution is from the optimum. `model`: that of solve(); optimal() holds.
  [[nodiscard]] HD_REALTIME ProgramResidual
  residual(const Linearisation& model, const CouplingStiffness& stiffness) const noexcept {
    return program_residual(problem_, solution_, model, stiffness);
  }

  /// Leaves out of the step of the first `strings` what only takes vertices to the centres of their
  /// contacts.
  HD_REALTIME void drop_centring(std::size_t strings) noexcept;

 private:
  struct Context;
  void choose_rows(const Context& context) noexcept;
  void fill_rows(const Context& context) noexcept;
  void add_worst(std::size_t kept, std::size_t most, std::size_t count) noexcept;
  void sort_by_string(const ContactSet& contacts, std::size_t pressed) noexcept;
  [[nodiscard]] std::size_t keep_worst_of_strings(const ContactView& view,
                                                  std::size_t violated) noexcept;
  [[nodiscard]] std::size_t find_violated(const Context& context, const Unknowns& y,
                                          double& fraction) noexcept;
  [[nodiscard]] double exchange_rows(const Context& context, const Unknowns& y,
                                     ContactResult& result) noexcept;
  [[nodiscard]] double solve_rows(const Context& context, QpWarmStart warm,
                                  ContactResult& result) noexcept;
  [[nodiscard]] double solve_from_first(const Context& context, ContactResult& result) noexcept;

  QpProblem problem_;
  QpWorkspace qp_;
  QpSolution solution_;
  std::array<std::int32_t, kMaxQpRows> contact_of_row_;  ///< index in the contacts
  std::array<std::int32_t, kMaxCandidates> order_;       ///< selection of rows
  std::array<double, kMaxCandidates> excess_;            ///< violation per contact, m
  ConfigurationStep step_;
  double feasible_fraction_ = 0.0;
  int pressed_ = 0;  ///< rows that bore force last, the first ones
};

}  // namespace hapticd
