// One tool, one tick: pose of the hand in, graphic tool and wrench out. Motion of the hand ->
// contact problem -> force of each string -> (what vibrating strings add, by the caller) ->
// ramped in after a recovery -> limit. A pure function of state and input: no clock, device or
// random source. RT: yes.
#pragma once

#include "core/contact/contact_problem.h"
#include "core/contact/contact_stiffness.h"
#include "core/contact/string_forces.h"
#include "core/safety/wrench_limit.h"
#include "core/tick/tick.h"

namespace hapticd {

/// Greatest force while G is pushed out of an overlap, N. Larger would let an edited scene shove
/// the player's hand.
inline constexpr double kRecoveryForce = 2.0;
/// Growth of the force bound during and after a recovery, N/s: 1 N within 20 ms.
inline constexpr double kRecoveryForceRate = 50.0;

/// Longest step of time that is integrated over at once, s; a longer pause counts as this much.
inline constexpr double kMaxElapsed = 5e-3;

/// Kept from tick to tick.
struct HandMotion {
  Pose X_WH;   ///< last pose, normalised
  Twist V_WH;  ///< by difference of poses; kept while no time passes
  std::int64_t t_ns = 0;
  bool has_pose = false;
};

/// The tick of `hand`. Returns the time since the pose before, s: 0 for the first one and for a
/// repeated or backward time stamp, at most kMaxElapsed.
[[nodiscard]] HD_REALTIME double follow(const HandPose& hand, HandMotion& motion) noexcept;

/// Where a string can lie on something that does not move: a fret, a bridge, a board.
struct StringRest {
  std::int32_t string = 0;
  double lambda = 0.5;    ///< place along the string, (0, 1)
  Vector3 p_W;            ///< of the string's axis when it lies there, m
  Vector3 nhat_W;         ///< unit, across the string, from what it lies on to it
  double friction = 0.0;  ///< Coulomb's coefficient
  /// One of many places of a surface along the string: between them it goes on.
  bool surface = false;
};

/// What stays the same from tick to tick; views must outlive the ticks.
struct ToolScene {
  SphereTreeView tool;
  ObstaclesView obstacles;
  CouplingStiffness stiffness;
  ContactOptions options;
  WrenchLimits limits;
  /// Strings that are more than rigid lines: the first capsules of the obstacles, in their order.
  std::span<const StringConstants> strings{};
  /// By string, and by their places on it.
  std::span<const StringRest> rests{};
  InstrumentOptions instrument{};
  ToolParts parts{};  ///< what of the tool is soft
  /// B of the coupling between hand and tool, N s/m, >= 0; acts on the hand's velocity against G's.
  double coupling_damping = 0.0;
  OtherTools others{};                 ///< see ContactInput
  double rounding = 0.0;               ///< likewise
  RigidCoefficients rigid_friction{};  ///< likewise
  bool stiffness_wanted = false;       ///< ticks tell RenderedTool::stiffness
  StageClock* clock = nullptr;         ///< lent, the same to all tools; null: no time is taken
  std::span<const RigidPart> rigid_parts{};  ///< see ContactInput
};

/// State of one tool. Copy it to take a snapshot.
struct ToolState {
  HandMotion hand;
  ContactState contact;
  bool placed = false;  ///< G has been put where H first was
  /// Bound on |f| after a recovery, N; infinite in normal operation.
  double force_bound = std::numeric_limits<double>::infinity();
};

/// What a tick gave of one tool, for the later stages of the same tick.
struct RenderedTool {
  double dt = 0.0;  ///< since the last sample, s; 0 without a new one
  Pose X_WH;
  Twist V_WH;
  Pose X_WG;
  Wrench F_H_W;           ///< for the device: ramped and limited, about the origin of G, N and N m
  Wrench F_computed_H_W;  ///< before ramp and limit
  ContactResult contact;
  PressedStrings strings;  ///< that press the tool
  /// Of F_computed_H_W less what vibrates; strings that do not yield count by the share of their
  /// force in the program's. Zero unless wanted.
  ContactStiffness stiffness;
};

/// What the contact problem is asked in a tick of this scene.
[[nodiscard]] HD_REALTIME ContactInput contact_input(const ToolScene& scene, const Pose& X_WH,
                                                     double dt) noexcept;

/// Everything of a tick up to F_computed_H_W. `work_budget` as in ContactInput.
HD_REALTIME void render_contact(const ToolScene& scene, const HandPose& hand, ToolState& state,
                                ContactProblem& problem, RenderedTool& tick,
                                std::int64_t work_budget = 0) noexcept;

/// The rest: F_H_W from F_computed_H_W, ramped and limited. Once per tick.
HD_REALTIME void limit_wrench(const ToolScene& scene, ToolState& state,
                              RenderedTool& tick) noexcept;

}  // namespace hapticd
