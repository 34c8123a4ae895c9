// What the contact problem of one tool is asked in a tick. Frames: W. SI. RT: yes, plain data.
#pragma once

#include <cstdint>
#include <span>

#include "core/collision/query.h"
#include "core/contact/contact_options.h"
#include "core/contact/grip.h"
#include "core/contact/other_tools.h"
#include "core/contact/soft_part.h"
#include "core/contact/virtual_coupling.h"
#include "core/instrument/deflection.h"
#include "core/instrument/instrument_options.h"
#include "core/tick/stage_clock.h"

namespace hapticd {

/// A part of a string that is a rigid line to the tool, which is a capsule beyond those of the
/// scene.
struct RigidPart {
  std::int32_t string = 0;
  double lambda_from = 0.0;  ///< along the string, of the part's ends
  double lambda_to = 1.0;
};

/// What one tool asks of its contact problem in one tick. Views must outlive the call.
struct ContactInput {
  SphereTreeView tool;  ///< in G
  ObstaclesView obstacles;
  Pose X_WH;  ///< sanitised pose of the haptic tool
  CouplingStiffness stiffness;
  ContactOptions options;
  double dt = 1e-3;  ///< time since the last tick, s, >= 0; limits only the recovery speed
  /// Strings that are more than rigid lines: the first capsules of the obstacles, in their order.
  std::span<const StringConstants> strings{};
  InstrumentOptions instrument{};  ///< friction and lateral force are the problem's
  ToolParts parts{};               ///< what of the tool is soft
  OtherTools others{};             ///< that no string may be moved into
  /// Overlaps up to this count as touching, m; 0 but where strings are shared, whose shapes are
  /// rounded as they pass from tool to tool.
  double rounding = 0.0;
  /// The tick ends before a linearisation that would take its work (tick_work.h) beyond this, as
  /// the last one and the last traversal went; the first is always made. 0: no bound. Less: the
  /// tool lags more.
  std::int64_t work_budget = 0;
  /// Coulomb coefficients of lines and bodies; felt where the instrument has friction.
  RigidCoefficients rigid_friction{};
  StageClock* clock = nullptr;  ///< lent; null: no time is taken
  /// Of strings that lie on rests: what the last capsules are, in their order. A string and its
  /// parts are one thing to friction, which they bear together.
  std::span<const RigidPart> rigid_parts{};
};

/// Number of the string that a capsule is a rigid part of; -1: of none.
[[nodiscard]] inline std::int32_t string_of_part(const ContactInput& input,
                                                 std::int32_t capsule) noexcept {
  const std::size_t others = input.obstacles.capsules_W.size() - input.rigid_parts.size();
  const auto number = static_cast<std::size_t>(capsule);
  return number < others ? -1 : input.rigid_parts[number - others].string;
}

}  // namespace hapticd
