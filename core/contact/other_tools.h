// The other tools of a scene, as one that moves a string has to see them: a string is never moved
// into any of them, whoever moves it. Tools stand still while another one is rendered. Frames: W.
// SI. RT: yes; 50 ns per string and tool that is far, about 1 us where one is in the way.
#pragma once

#include <span>

#include "core/collision/query.h"
#include "core/contact/soft_part.h"
#include "core/contact/touched_string.h"

namespace hapticd {

/// Clearance that a moving string keeps from other tools, m; one that is nearer is not approached.
/// Larger: a tool is noticed by what it is in the way of before it touches; smaller than the
/// rounding of a gap would let strings in.
inline constexpr double kOtherToolClearance = 1e-6;

/// Another tool where it stands. Views must outlive it.
struct OtherTool {
  SphereTreeView tool;
  Pose X_WG;
  ToolParts parts;
  const TouchedParts* soft = nullptr;  ///< never null where it is looked at
  double clearance = 0.0;              ///< that it keeps, m
};

/// All others, and memory to look at them with; none: nothing is shared.
struct OtherTools {
  std::span<const OtherTool> tools{};
  ContactSet* scratch = nullptr;  ///< never null with tools
};

/// True when the string `bend`, of which `straight_W` is the capsule, meets none of the others on
/// its way through `motion`, to within a quarter of a micrometre between places looked at.
[[nodiscard]] HD_REALTIME bool clear_of_other_tools(const OtherTools& others,
                                                    const Capsule& straight_W,
                                                    const StringBend& bend,
                                                    const StringMotion& motion) noexcept;

}  // namespace hapticd
