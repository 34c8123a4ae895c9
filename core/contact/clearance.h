// How far a tool keeps off what it touches while it moves. Turning needs room: a step by t that
// turns a length l, of the tool or of a string's leg, leaves its linearisation by t^2 / (2 l), and
// legs may be as short as the step. So a share of the hand's motion in a tick is kept, up to the
// skin; it halves with every tick that settles, so that a tool at rest stands on the exact surface.
// It steers the solver alone: the force of every tick is that of the surface itself
// (RowProgram::solve_surface). SI. RT: yes, a few ns.
#pragma once

#include <algorithm>

#include "core/contact/contact_options.h"
#include "core/tick/contact_tick.h"

namespace hapticd {

/// The least clearance, m: what a skin of 0 counts as. Far above the rounding of gaps, far below
/// what is felt. Smaller: steps refused for rounding.
inline constexpr double kLeastClearance = 1e-9;
/// Clearance over the hand's travel in a tick. Larger: forces that differ more from the exact
/// surface's just before a tool slips off a string, by 86 mN at a quarter and 39 mN here in the
/// worst tick of tests/core/contact/string_reference_test; smaller: more steps refused.
inline constexpr double kClearancePerTravel = 0.0625;
/// What a settled tick leaves of the clearance. Less: steps of the shown tool as it comes to rest.
inline constexpr double kClearanceDecay = 0.5;

/// The most that is kept, m.
[[nodiscard]] inline double skin_of(const ContactOptions& options) noexcept {
  return std::max(options.skin, kLeastClearance);
}

/// What a tick keeps whose hand goes `travel` (m) after one that kept `before`.
[[nodiscard]] inline double clearance_for(const ContactOptions& options, double before,
                                          double travel) noexcept {
  return std::min(std::max(before, kClearancePerTravel * travel), skin_of(options));
}

/// What is left of `clearance` after a tick that ended so: all of the skin where it was refused,
/// since a tool without room may be held by its linearisation alone.
[[nodiscard]] inline double clearance_after(const ContactOptions& options, double clearance,
                                            ContactStatus status) noexcept {
  if (status == ContactStatus::kLagging) return clearance;
  const bool settled = status == ContactStatus::kFree || status == ContactStatus::kConverged;
  return settled ? std::max(kClearanceDecay * clearance, kLeastClearance) : skin_of(options);
}

}  // namespace hapticd
