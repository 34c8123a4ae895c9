// Sanitises the pose stream of a device before anything computes with it: a bad sample holds the
// last good pose for at most two ticks, then a fault is latched. Also the motion between samples:
// velocity by true elapsed time, none from a repeated or backward time stamp. RT: yes, about 20 ns.
#pragma once

#include <cstdint>

#include "core/math/pose.h"
#include "core/math/realtime.h"
#include "core/math/wrench.h"

namespace hapticd {

/// Positions beyond this are garbage, not motion, m.
inline constexpr double kMaxPosition = 1e7;
/// |q| of a usable sample lies in [kMinQuaternionNorm, kMaxQuaternionNorm]; it is then normalised.
inline constexpr double kMinQuaternionNorm = 0.5;
inline constexpr double kMaxQuaternionNorm = 2.0;
/// Ticks a bad or missing sample is bridged with the last good pose. More: a longer phantom
/// contact; fewer: faults on one glitch.
inline constexpr int kMaxHeldTicks = 2;

/// One pose sample as it arrives, in W, unchecked.
struct PoseSample {
  std::int64_t t_ns = 0;  ///< sample time of the device, monotonic, ns
  Array3 p_WH{};          ///< m
  Array4 q_WH{1.0, 0.0, 0.0, 0.0};
};

enum class PoseVerdict : std::uint8_t {
  kGood,   ///< the sample is used
  kHeld,   ///< bad sample, the last good pose stands in
  kFault,  ///< latched: too many bad samples in a row, or none good yet; render a zero wrench until
           ///< cleared
};

struct PoseGuard {
  Pose X_WH;   ///< last good pose
  Twist V_WH;  ///< its velocity by finite difference; zero after a hold
  std::int64_t t_ns = 0;
  int bad_in_a_row = 0;
  bool has_pose = false;
  bool fault = false;
  std::uint64_t bad_total = 0;
};

/// Judges `sample` and updates `guard`; guard.X_WH is then the pose to use. dt_s receives the time
/// since the last good sample, 0 for a repeated, backward or held one, never more than kMaxElapsed.
[[nodiscard]] HD_REALTIME PoseVerdict accept_pose(const PoseSample& sample, PoseGuard& guard,
                                                  double& dt_s) noexcept;

/// Longest step of time the renderer integrates over at once, s; a longer pause counts as this
/// much.
inline constexpr double kMaxElapsed = 5e-3;

}  // namespace hapticd
