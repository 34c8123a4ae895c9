// Configuration-based optimisation of the graphic tool (Eq. 5-7): per tick, G moves from its last
// committed, collision-free pose towards the haptic tool H as far as the non-penetration
// constraints let it, and the multipliers of those constraints are the force. Detection is around
// G, never around H; the signed distance is constrained, not its square (convex, so the linearised
// half-space is conservative for translation along the whole step).
// Safe at any time: a step is committed only after an exact look at its way, so stopping early
// means that the tool lags, never that it penetrates. Frames: W; wrench and steps about the origin
// of G. RT: yes; work bounded by sub_steps and the capacities.
#pragma once

#include <array>
#include <cstdint>

#include "core/contact/contact_input.h"
#include "core/contact/contact_result.h"
#include "core/contact/contact_state.h"
#include "core/contact/string_elimination.h"
#include "core/math/symmetric_matrix.h"
#include "core/solver/active_set.h"

namespace hapticd {

/// The quadratic model of a linearisation in coordinates z in which it is round (local_model.h).
struct LocalModel {
  /// y = basis z, of the core: all unknowns, or those before the strings' where these are
  /// eliminated. Its size is theirs.
  SquareMatrix basis;
  std::array<double, kMaxQpUnknowns> target_z;  ///< unconstrained minimiser in z
  std::size_t unknowns = 0;                     ///< core and strings
  std::array<EliminatedString, kMaxDeflectingStrings> strings;

  /// The strings that are eliminated, in the order of their unknowns.
  [[nodiscard]] std::span<const EliminatedString> eliminated() const noexcept {
    return std::span(strings).first((unknowns - basis.size) / 2);
  }
};

/// Scratch memory of one tool, 1.5 MB; contents mean nothing between ticks.
struct OptimiserWorkspace {
  QpProblem problem;
  QpWorkspace qp;
  ContactSet contacts;
  QpSolution solution;
  std::array<std::int32_t, kMaxQpRows> contact_of_row;  ///< index in contacts
  StringBlocks models;                                  ///< of the held strings
  PartBlocks parts;                                     ///< of the soft parts
  LocalModel model;
  ConfigurationStep step;                          ///< full step of the last program
  std::array<std::int32_t, kMaxCandidates> order;  ///< selection of rows
  std::array<double, kMaxCandidates> excess;       ///< violation per contact, m
  /// How far tool points may have moved since the last traversal, m.
  double travelled = 0.0;
  double pace = 0.0;   ///< way of any point of the tool or the hand in a tick, at most, m
  bool stale = false;  ///< contacts describe an earlier pose
  /// The last program's full step was taken, and its contacts have not been queried anew.
  bool full_step = false;
  bool leaves = false;  ///< this tick goes by the leaves, whatever the options say
  /// Work of the tick before the last linearisation, traversals left out.
  std::int64_t linearised = 0;
};

/// Queries the contacts around `state.X_WG` and starts the tick.
HD_REALTIME void start_tick(const ContactInput& input, ContactState& state,
                            OptimiserWorkspace& workspace, ContactResult& result) noexcept;

/// Brings the contacts up to date and takes up or lets go of strings, which moves nothing.
/// advance_sub_step begins with it; a second call finds nothing to do.
/// Returns the error of G to H.
HD_REALTIME PoseError prepare_sub_step(const ContactInput& input, ContactState& state,
                                       OptimiserWorkspace& workspace,
                                       ContactResult& result) noexcept;

/// One linearisation: rows, program, scaled step, exact re-check, commit. Between two calls the
/// committed path of G is the screw motion X(s) = moved(X_before, s * step), s in [0, 1], the
/// vertices of the held strings go straight with it, and the soft parts straight in G. Returns true
/// while another sub-step may help. Precondition: start_tick and no negative gap.
HD_REALTIME bool advance_sub_step(const ContactInput& input, ContactState& state,
                                  OptimiserWorkspace& workspace, ContactResult& result) noexcept;

/// True where the work budget leaves no room for a linearisation such as the last one, and for
/// looking around anew where that is due. To be asked once after each.
[[nodiscard]] HD_REALTIME bool work_used_up(const ContactInput& input, const ContactResult& result,
                                            OptimiserWorkspace& workspace) noexcept;

/// Ends the tick: where friction slips its anchor follows, and what its spring exceeds mu N by is
/// lost as heat.
HD_REALTIME void finish_tick(const ContactInput& input, ContactState& state) noexcept;

/// The whole tick: start, then up to `sub_steps` linearisations as far as the work budget goes, or
/// recovery where a gap is negative.
HD_REALTIME void optimise_configuration(const ContactInput& input, ContactState& state,
                                        OptimiserWorkspace& workspace,
                                        ContactResult& result) noexcept;

}  // namespace hapticd
