// The methods ours is compared with, tick by tick on the same stream of poses: the paper as it is
// printed, and a penalty method. For the lab alone: nothing that plays uses them. Frames: W,
// wrenches on the hand. SI. Not RT.
//
// kPaper: detection at the haptic pose H, sphere-tree against sphere-trees and against cylinders
// with flat ends (Eq. 1-4); one program (Eq. 5-7) per tick for the graphic pose G; the 6-D spring
// from H to G, on strings Eq. 10-13 and, where one rings, Eq. 8-9. What the text leaves open, and
// how it is decided, each time in the paper's favour:
//   - Eq. 6 is quadratic in the pose: it is linearised at the last G, with the pairs found at H.
//     (At H the normal turns round once a sphere's centre has passed the axis.) Eq. 2's missing
//     division by |AB|^2 is done.
//   - The margin of lambda: 0.005 at either end, an option.
//   - r_c: the cylinder's radius grows by delta under a finger and by Eq. 9's envelope
//     r_max exp(-t / T_d) after a release. What of it the collision follows is an option: nothing,
//     the envelope, or both. With both delta follows from a radius that follows from delta,
//     delta' = depth + delta / k_s, which grows without bound where k_s <= 1. With the envelope the
//     cylinder swells to r_max in the tick of the release, around a finger that has just left, and
//     so is touched again, deeper, and released with a larger r_max: a strum may diverge too.
//   - F_r is defined twice, as the spring's force and by Eq. 10. While only strings are touched it
//     is Eq. 10, along the spring, at the lambda of the deepest pair ("the active string"); while
//     anything else is touched it is the spring's. The torque is the spring's.
//   - delta of every touched string is |p_G - p_H| / k_s, as Eq. 13 has it, whatever else is
//     touched.
//   - F_v of all touched strings that ring adds along F_r; k_v = T / (L lambda (1 - lambda)) at the
//     release; t = 0 at the release; T_d and omega are the scene's. A string is released in the
//     first tick in which no sphere overlaps it at H.
//   - More pairs than rows: the deepest stay. A program without a solution: G stays.
// kPenalty: G is H; every sphere that overlaps something, round ends, is pushed out along the
// nearest normal with kt times its depth.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/simulation/tool_renderer.h"
#include "tests/oracle/printed_string.h"

namespace hapticd {

enum class BaselineMethod : std::uint8_t { kPaper, kPenalty };

/// What of a string's growing radius the paper's collision follows.
enum class Breathing : std::uint8_t { kNone, kReleased, kAlways };

struct BaselineOptions {
  BaselineMethod method = BaselineMethod::kPaper;
  double lambda_margin = 0.005;  ///< see above, share of the string's length
  Breathing breathing = Breathing::kReleased;
  PrintedVibrationOptions vibration;
};

/// What one tick gives.
struct BaselineTick {
  Pose X_WG;
  Wrench F_H_W;                ///< about the origin of H
  double repulsion = 0.0;      ///< |F_r|, N
  double vibration = 0.0;      ///< F_v along F_r, N
  double deflection = 0.0;     ///< delta of Eq. 13, m; 0 where no string is touched
  double radius_growth = 0.0;  ///< largest r(t) of a string in the collision, m
  std::size_t pairs = 0;       ///< found at H
  bool solved = true;          ///< the program had a solution
};

class Baseline {
 public:
  /// `scene`'s views are looked at, now and later; the tool begins where it is first led.
  Baseline(const ToolScene& scene, const BaselineOptions& options);
  ~Baseline();
  Baseline(Baseline&&) = delete;
  Baseline& operator=(Baseline&&) = delete;

  /// Leads the tool to X_WH; dt in s. Stiffness and strings are those of `scene`, obstacles and
  /// tool those of the first.
  [[nodiscard]] BaselineTick tick(const ToolScene& scene, const Pose& X_WH, double dt_s);

 private:
  class Method;
  std::unique_ptr<Method> method_;
};

}  // namespace hapticd
