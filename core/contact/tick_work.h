// What a tick of a tool has done, as one number that budgets are set in: a weighted sum of what was
// counted. A unit is one pair of spheres or bounds tested in a traversal; the weights are the CPU
// times of the parts over that one, fitted to contact sessions, within a third of the time of
// nearly every tick. No clock is read: the same input gives the same work everywhere. RT: yes, a
// few ns.
#pragma once

#include <cstdint>

#include "core/contact/contact_result.h"

namespace hapticd {

/// Units of a linearisation: its local model and path.
inline constexpr std::int64_t kSubStepWork = 570;
/// Of a pair that bore force before: its curvature in the model.
inline constexpr std::int64_t kPressedWork = 590;
/// Of a row of the program.
inline constexpr std::int64_t kRowWork = 35;
/// Of an iteration of the program.
inline constexpr std::int64_t kIterationWork = 200;
/// Of a pair of strings that the model eliminates, where more than kMaxDenseStrings yield: what
/// their rows cost in the program.
inline constexpr std::int64_t kStringPairWork = 20;
/// Of a pair evaluated by itself, beyond the test it counts as.
inline constexpr std::int64_t kEvaluationWork = 15;

/// Time of a unit where none was measured, ns: that of the machine the weights are from.
inline constexpr double kNominalWork_ns = 1.4;

/// Work of a tick, or of the part of it that is done; >= 0.
[[nodiscard]] inline std::int64_t tick_work(const ContactSummary& result) noexcept {
  return result.tests + kEvaluationWork * result.evaluations + kRowWork * result.rows +
         kIterationWork * result.qp_iterations + kPressedWork * result.pressed +
         kSubStepWork * result.sub_steps + kStringPairWork * result.string_pairs;
}

/// The same without the traversals.
[[nodiscard]] inline std::int64_t linearisation_work(const ContactSummary& result) noexcept {
  return tick_work(result) - (result.tests - result.evaluations);
}

/// What one more pair near the tool adds to a linearisation: the looks at it.
inline constexpr std::int64_t kPairWork = 3 * (1 + kEvaluationWork);

}  // namespace hapticd
