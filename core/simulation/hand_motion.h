// How the hand moves from tick to tick, by the poses that the guard has let through
// (core/safety/pose_guard.h): velocity by true elapsed time, none from a repeated or backward time
// stamp. Frame: W. SI. RT: yes, about 20 ns.
#pragma once

#include <cstdint>

#include "core/math/pose.h"
#include "core/math/realtime.h"
#include "core/math/wrench.h"

namespace hapticd {

/// Longest step of time that is integrated over at once, s; a longer pause counts as this much.
inline constexpr double kMaxElapsed = 5e-3;

/// Where the hand is in a tick: a judged pose, brought to W. Finite, within kMaxPosition.
struct HandPose {
  std::int64_t t_ns = 0;            ///< when the sample was made, monotonic
  Array3 p_WH{};                    ///< m
  Array4 q_WH{1.0, 0.0, 0.0, 0.0};  ///< |q| in [0.5, 2]
};

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

}  // namespace hapticd
