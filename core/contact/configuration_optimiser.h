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
#include <limits>

#include "core/collision/query.h"
#include "core/contact/other_tools.h"
#include "core/contact/soft_part.h"
#include "core/contact/string_elimination.h"
#include "core/contact/string_hold.h"
#include "core/contact/virtual_coupling.h"
#include "core/math/symmetric_matrix.h"
#include "core/solver/active_set.h"

namespace hapticd {

/// The knobs that trade speed for accuracy; the effect of each is measured by tests/benchmark (see
/// README).
struct OptimiserOptions {
  /// Linearisations per tick, at most; >= 1. A steady contact takes 2 or 3, a slip off an edge up
  /// to some 30; fewer: the tool lags behind for a tick or two while it slips.
  int sub_steps = 32;
  /// Pairs nearer than this enter the program, and no tool point moves further in one
  /// linearisation, m. At most: a tool that moves slowly looks less far.
  double margin = 5e-3;
  /// Clearance kept where there is room, m: the reservoir for the second-order error of rotation;
  /// what a step takes of it later ones win back. Felt as a fatter obstacle.
  double skin = 20e-6;
  /// Rotation per linearisation, rad: bounds the second-order error dtheta^2 reach / 2.
  double rotation_step = 0.05;
  /// The tick ends when the step wanted moves no tool point further than this, m.
  double stop_tolerance = 1e-6;
  /// See QueryOptions. A tick that starts within the bounds of a coarse level goes by the leaves. A
  /// change waits until nothing bears force.
  int tool_level = kLeafLevel;
  int body_level = kLeafLevel;
  /// Rows of the program, [1, kMaxQpRows]; fewer: more exchanges of rows, then shorter steps.
  int max_rows = kMaxQpRows;
  /// Speed at which a tool that starts inside something is pushed out, m/s, > 0. Faster throws the
  /// shown tool about, slower prolongs the overlap.
  double recovery_speed = 2.0;
};

/// What one tool asks of the optimiser in one tick. Views must outlive the call.
struct OptimiserInput {
  SphereTreeView tool;  ///< in G
  ObstaclesView obstacles;
  Pose X_WH;  ///< sanitised pose of the haptic tool
  CouplingStiffness stiffness;
  OptimiserOptions options;
  double dt = 1e-3;  ///< time since the last tick, s, >= 0; limits only the recovery speed
  /// Strings that are more than rigid lines: the first capsules of the obstacles, in their order.
  std::span<const StringConstants> strings{};
  InstrumentOptions instrument{};  ///< friction and lateral force are the optimiser's
  ToolParts parts{};               ///< what of the tool is soft
  OtherTools others{};             ///< that no string may be moved into
  /// Overlaps up to this count as touching, m; 0 but where strings are shared, whose shapes are
  /// rounded as they pass from tool to tool.
  double rounding = 0.0;
  /// The tick ends before a linearisation that would take its work (tick_work.h) beyond this, as
  /// the last one and the last traversal went; the first is always made. 0: no bound. Less: the
  /// tool lags more.
  std::int64_t work_budget = 0;
};

/// The strings of a tick as string_hold.h wants them.
[[nodiscard]] inline StringContext string_context(const OptimiserInput& input) noexcept {
  return {input.obstacles, input.strings, input.instrument, input.stiffness.kt};
}

/// A pair that carried force, and how much.
struct ActivePair {
  ContactKey key;
  double multiplier = 0.0;  ///< N
};

/// State of one tool from tick to tick.
struct OptimiserState {
  Pose X_WG;                        ///< last committed pose
  Vector3 phi_GH_W{0.0, 0.0, 0.0};  ///< last rotation error: the branch latch
  Wrench F_H_W;                     ///< last force from multipliers
  int active_count = 0;             ///< pairs that carried force last: warm start and curvature
  std::array<ActivePair, kMaxQpUnknowns> active;
  StringHolds holds;  ///< strings touched: how they are bent and what sticks to them
  SoftParts parts;    ///< soft parts that are touched or displaced
  /// Levels of the options at the last tick that began without force: bounds are another shape, and
  /// what is pressed keeps its own until it is let go of.
  int tool_level = kLeafLevel;
  int body_level = kLeafLevel;
  Pose X_WH;         ///< of the last tick
  double way = 0.0;  ///< of any point of the tool in the last tick, at most, m
};

/// No point of the tool with its soft parts is farther from its origin, m.
[[nodiscard]] inline double tool_reach(const OptimiserInput& input,
                                       const OptimiserState& state) noexcept {
  return reach(input.tool) + greatest_displacement(state.parts);
}

/// One pair that carries force. The pair's contact force on the tool is multiplier * nhat_OG_W at
/// p_WC.
struct ActiveContact {
  std::int32_t contact = 0;  ///< index in OptimiserWorkspace::contacts
  double multiplier = 0.0;   ///< N, >= 0
};

enum class OptimiserStatus : std::uint8_t {
  kFree,        ///< nothing in the way: G coincides with H
  kConverged,   ///< the wanted step fell below stop_tolerance
  kLagging,     ///< sub-steps or work used up before convergence
  kRefused,     ///< no admissible step found: G kept
  kQpFailed,    ///< solver gave up: G kept, force not larger than before
  kRecovering,  ///< a gap was negative at the start: being pushed out
};

/// What the tick did.
struct OptimiserResult {
  OptimiserStatus status = OptimiserStatus::kFree;
  /// On the hand, about the origin of G, before any limit: of the contacts, of friction and of
  /// strings that pull along their axis; N, N m.
  Wrench F_H_W;
  int active_count = 0;
  std::array<ActiveContact, kMaxQpUnknowns> active;
  int strings_refused = 0;  ///< strings that stayed rigid because kMaxDeflectingStrings are held
  int parts_refused = 0;    ///< soft parts that stayed rigid because kMaxSoftParts yield
  int sub_steps = 0;        ///< linearisations used
  int qp_iterations = 0;
  int queries = 0;         ///< tree traversals
  int rows_exchanged = 0;  ///< rows brought in because more pairs than rows mattered
  int halvings = 0;        ///< trial steps refused by the exact re-check or the energy test
  std::int64_t tests = 0;
  std::int64_t evaluations = 0;   ///< of the tests those of single pairs, once they were found
  std::int64_t rows = 0;          ///< filled, of all programs
  std::int64_t pressed = 0;       ///< pairs that bore force before, of all linearisations
  std::int64_t string_pairs = 0;  ///< of strings that were eliminated, of all programs
  bool cut_short = false;         ///< the work budget ended the tick
  double minimum_gap = 0.0;       ///< at the last evaluated pose, m
};

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
  HoldModels models;                                    ///< of the held strings
  PartModels parts;                                     ///< of the soft parts
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
HD_REALTIME void start_tick(const OptimiserInput& input, OptimiserState& state,
                            OptimiserWorkspace& workspace, OptimiserResult& result) noexcept;

/// Brings the contacts up to date and takes up or lets go of strings, which moves nothing.
/// advance_sub_step begins with it; a second call finds nothing to do.
/// Returns the error of G to H.
HD_REALTIME ToolStep prepare_sub_step(const OptimiserInput& input, OptimiserState& state,
                                      OptimiserWorkspace& workspace,
                                      OptimiserResult& result) noexcept;

/// One linearisation: rows, program, scaled step, exact re-check, commit. Between two calls the
/// committed path of G is the screw motion X(s) = moved(X_before, s * step), s in [0, 1], the
/// vertices of the held strings go straight with it, and the soft parts straight in G. Returns true
/// while another sub-step may help. Precondition: start_tick and no negative gap.
HD_REALTIME bool advance_sub_step(const OptimiserInput& input, OptimiserState& state,
                                  OptimiserWorkspace& workspace, OptimiserResult& result) noexcept;

/// True where the work budget leaves no room for a linearisation such as the last one, and for
/// looking around anew where that is due. To be asked once after each.
[[nodiscard]] HD_REALTIME bool work_used_up(const OptimiserInput& input,
                                            const OptimiserResult& result,
                                            OptimiserWorkspace& workspace) noexcept;

/// Ends the tick: where friction slips its anchor follows, and what its spring exceeds mu N by is
/// lost as heat.
HD_REALTIME void finish_tick(const OptimiserInput& input, OptimiserState& state) noexcept;

/// The whole tick: start, then up to `sub_steps` linearisations as far as the work budget goes, or
/// recovery where a gap is negative.
HD_REALTIME void optimise_configuration(const OptimiserInput& input, OptimiserState& state,
                                        OptimiserWorkspace& workspace,
                                        OptimiserResult& result) noexcept;

}  // namespace hapticd
