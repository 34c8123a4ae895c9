// What a simulation keeps of each of its tools, and of each string that a tool comes to. Frames: W.
// SI. RT: yes, plain data; 0.7 MB per tool, most of it scratch.
#pragma once

#include "core/instrument/string_model.h"
#include "core/simulation/string_segments.h"
#include "core/simulation/tool_renderer.h"

namespace hapticd {

/// What a tool was asked to do in a tick, and from where.
struct ToolWay {
  ContactInput input;
  Pose X_WG_before;
  Pose X_WH_before;
  ToolMotion hand;  ///< from X_WH_before on
  TickTime time;
};

/// One tool of a simulation. Set `scene`; the rest begins as it is. Strings, obstacles and
/// instrument are the same for all tools of a simulation.
struct ToolPlay {
  ContactProblem problem;  ///< first, for it is aligned
  ToolScene scene;
  ToolState state;
  Pose X_WH;    ///< of the last tick in which time passed
  ToolWay way;  ///< of this tick
  StringSegments view;
  ContactSet swung;          ///< pairs with strings alone, as far as these swing (reach_out)
  bool reached_out = false;  ///< in this tick: `swung` counts
};

/// Pairs of the tool and the strings it may meet in this tick, each way it may.
[[nodiscard]] inline const ContactSet& string_pairs(const ToolPlay& play) noexcept {
  return play.reached_out ? play.swung : play.problem.candidates().contacts();
}

/// A tool's view of a string, from tick to tick.
struct ToolStringState {
  double distance = 1.0;       ///< StringTouch::distance of the last tick, m; 1: not near
  Vector3 u_W{0.0, 0.0, 0.0};  ///< deflection, m
  Vector3 v_W{0.0, 0.0, 0.0};  ///< its rate over the last tick, m/s
  /// Where its vibration has pushed the tool since: the normal, and the place from G, m.
  Vector3 nhat_W{0.0, 0.0, 0.0};
  Vector3 p_GC_W{0.0, 0.0, 0.0};
  std::int32_t part = -1;  ///< of the tool, that was nearest when one was near
  /// The touch, while another tool plays the string (PlayedString::player).
  ReleaseDetector detector;
};

}  // namespace hapticd
