// The contact problem of one tool (Eq. 5-7): per tick, G moves from its last committed,
// collision-free pose towards the haptic tool H as far as the non-penetration constraints let it,
// and the multipliers of those constraints are the force. Detection is around G, never around H;
// the signed distance is constrained, not its square (convex, so the linearised half-space is
// conservative for translation along the whole step).
// Safe at any time: a step is committed only after an exact look along its path, so stopping early
// means that the tool lags, never that it penetrates. Frames: W; wrench and steps about the origin
// of G. RT: yes; work bounded by sub_steps and the capacities.
#pragma once

#include <cstdint>

#include "core/collision/blended_surface.h"
#include "core/contact/candidates.h"
#include "core/contact/contact_view.h"
#include "core/contact/linearisation.h"
#include "core/contact/row_program.h"

namespace hapticd {

/// One tick of one tool, and the memory it is solved in, 1.4 MB, whose contents mean nothing
/// between ticks but for candidates(). What goes from tick to tick is the caller's ContactState.
/// Invariant: the committed configuration is admissible, the candidates are of it or known to be
/// stale (but after a recovery, which ends the tick), and the force is that of the last program.
class ContactProblem {
 public:
  /// The whole tick: begin, then up to `sub_steps` linearisations as far as the work budget goes,
  /// or recovery where a gap is negative.
  HD_REALTIME void solve(const ContactInput& input, ContactState& state,
                         ContactResult& result) noexcept;

  /// Queries the contacts around state.X_WG and begins the tick. All three must outlive it, and the
  /// last look at view().
  HD_REALTIME void begin(const ContactInput& input, ContactState& state,
                         ContactResult& result) noexcept;

  /// True when the tick begins with a negative gap: recover() then is all of it.
  [[nodiscard]] bool overlaps() const noexcept {
    return candidates_.contacts().minimum_gap < -input_->rounding;
  }

  /// One push out of an overlap. Leaves G where it is when no direction enlarges the gap. The force
  /// of the tick is the coupling's spring force; the caller limits it.
  HD_REALTIME void recover() noexcept;

  /// Brings the contacts up to date and takes up or lets go of strings and soft parts, which moves
  /// nothing. advance() begins with it; a second call finds nothing to do. Returns the error of G
  /// to H.
  HD_REALTIME PoseError prepare() noexcept;

  /// One linearisation: rows, program, scaled step, exact re-check, commit. Between two calls the
  /// committed path of G is the screw motion X(s) = moved(X_before, s * step), s in [0, 1], the
  /// vertices of the touched strings go straight with it, and the soft parts straight in G. Returns
  /// true while another one may help. Precondition: begin() found no overlap.
  HD_REALTIME bool advance() noexcept;

  /// True where the work budget leaves no room for a linearisation such as the last one, and for
  /// looking around anew where that is due. To be asked once after each.
  [[nodiscard]] HD_REALTIME bool work_used_up() noexcept;

  /// Ends the tick, unless it recovered.
  HD_REALTIME void finish() noexcept;

  /// The problem as the tick left it, or has come to.
  [[nodiscard]] ContactView view() const noexcept {
    return {*input_, *state_, candidates_.contacts(), strings_, parts_, friction_, *result_};
  }
  /// The pairs near the tool, also between ticks.
  [[nodiscard]] const Candidates& candidates() const noexcept { return candidates_; }
  /// For the obstacles of its inputs: what is near the tool on blended surfaces.
  [[nodiscard]] BlendMemory& blends() noexcept { return blends_; }
  /// Unknowns of the last program.
  [[nodiscard]] std::size_t unknowns() const noexcept { return program_.unknowns(); }

 private:
  [[nodiscard]] Configuration at() const noexcept { return {*input_, *state_}; }
  void touch(double wanted) noexcept;
  void commit_free(double travel) noexcept;
  [[nodiscard]] bool settled(const PoseError& error_GH, int unknowns) noexcept;
  [[nodiscard]] bool step_on(const PoseError& error_GH) noexcept;
  void render_surface() noexcept;
  void take_force(const PoseError& error_GH) noexcept;
  void bound_force(const PoseError& error_GH) noexcept;
  void keep_after_failure(const PoseError& error_GH) noexcept;
  void tell_residual() noexcept;

  RowProgram program_;  ///< first, for it is aligned
  Candidates candidates_;
  BlendMemory blends_;
  YieldingStrings strings_;
  SoftParts parts_;
  RigidFriction friction_;
  Linearisation linearisation_;
  const ContactInput* input_ = nullptr;
  ContactState* state_ = nullptr;
  ContactResult* result_ = nullptr;
  /// The last program's full step was taken, after so many queries of the tick.
  bool full_step_ = false;
  int queries_ = 0;
  /// Where the last program stands against the configuration: the step it asks for has yet to be
  /// gone, or is gone and found to be the last.
  enum class Solved : std::uint8_t { kNothing, kAhead, kArrived };
  Solved solved_ = Solved::kNothing;
  PoseError error_GH_;  ///< of the last program
  /// Pairs that bore force when the tick began.
  FixedVector<ContactKey, kMaxQpUnknowns> pressed_before_;
  Vector3 p_program_W_{0.0, 0.0, 0.0};  ///< origin of G where the last program was solved, m
  /// Work of the tick before the last linearisation, traversals left out.
  std::int64_t linearised_ = 0;
};

}  // namespace hapticd
