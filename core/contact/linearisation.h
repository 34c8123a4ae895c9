// The quadratic model of one linearisation. Eq. 5 alone sees flat obstacles: its steps then
// converge like (depth / radius)^k, slowly where a press is deep and hardly at all while a tip
// slips off. The model adds what Newton's method asks for: the curvature of the touched obstacles
// weighted with their multipliers, the rotation energy's, the stiffness of the strings that yield
// and of their friction, and of soft parts. With y the unknowns (unknowns.h)
//   H = G_phi + K + friction - sum mu_i hess(gap_i),   y = basis z  with  basis' H basis = 1,
// so that the program stays the projection of a point. During a slip H is indefinite; then the
// magnitudes of its eigenvalues count (saddle-free Newton, Dauphin et al., NIPS 2014). Frames: W;
// steps [dp; dtheta] about the origin of G. RT: yes, about 0.3 us with contacts.
#pragma once

#include <array>
#include <span>

#include "core/contact/contact_view.h"
#include "core/contact/coupling_axes.h"
#include "core/contact/string_elimination.h"
#include "core/math/symmetric_matrix.h"
#include "core/solver/qp_problem.h"

namespace hapticd {

/// Least eigenvalue of H relative to G and K. Smaller: longer leaps during a slip, more of them
/// refused.
inline constexpr double kMinStiffnessShare = 0.02;

/// What a row asks of a string.
struct StringTerm {
  std::size_t row;
  std::size_t unknown;  ///< of the radial deflection
  double radial;
  double tangential;
};

/// The quadratic model in coordinates z in which it is round, and the way from the unknowns y to
/// them and back.
class Linearisation {
 public:
  /// Models `view` with the error `error_GH`, the pairs that carried force and their multipliers,
  /// and strings and soft parts as they are built, with `unknowns` in all. The contacts must be up
  /// to date.
  HD_REALTIME void build(const ContactView& view, const PoseError& error_GH, int unknowns) noexcept;

  /// Unknowns, weights and target of the program.
  HD_REALTIME void set_objective(QpProblem& problem) const noexcept;
  /// Adds what a row asks of a string to it.
  HD_REALTIME void add_string(const StringTerm& term, QpProblem& problem) const noexcept;
  /// The unknowns that the solution means.
  HD_REALTIME void find_unknowns(const QpSolution& solution, Unknowns& y) const noexcept;

  /// y = basis z, of the core: all unknowns, or those before the strings' where these are
  /// eliminated. Its size is theirs.
  [[nodiscard]] const SquareMatrix& basis() const noexcept { return basis_; }
  /// Of core and strings.
  [[nodiscard]] std::size_t unknowns() const noexcept { return unknowns_; }
  /// The strings that are eliminated, in the order of their unknowns.
  [[nodiscard]] std::span<const EliminatedString> eliminated() const noexcept {
    return std::span(strings_).first((unknowns_ - basis_.size) / 2);
  }

 private:
  void find_target(Unknowns& downhill) noexcept;
  void leave_units(const RotationUnits& units, std::size_t strings) noexcept;
  void add_eliminated(const StringTerm& term, QpProblem& problem) const noexcept;

  SquareMatrix basis_;
  Unknowns target_z_;  ///< unconstrained minimiser in z
  std::size_t unknowns_ = 0;
  std::array<EliminatedString, kMaxDeflectingStrings> strings_;
};

}  // namespace hapticd
