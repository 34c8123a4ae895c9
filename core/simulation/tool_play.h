// What a simulation keeps of each of its tools, and of each string that a tool comes to. Frames: W.
// SI. RT: yes, plain data; 0.7 MB per tool, most of it scratch.
#pragma once

#include <array>
#include <span>

#include "core/instrument/string_model.h"
#include "core/instrument/wave_state.h"
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
  ToolState before;       ///< as this tick found it; scratch, of scenes with rests
  Pose X_WH;              ///< of the last tick in which time passed
  ToolWay way;            ///< of this tick
  RenderedTool rendered;  ///< likewise
  StringSegments view;
  ContactSet swung;          ///< pairs with strings alone, as far as these swing (reach_out)
  bool reached_out = false;  ///< in this tick: `swung` counts
};

/// Pairs of the tool and the strings it may meet in this tick, each way it may.
[[nodiscard]] inline const ContactSet& string_pairs(const ToolPlay& play) noexcept {
  return play.reached_out ? play.swung : play.problem.candidates().contacts();
}

/// True of a pair of the tool with a string that others hold, or a part of one: its shape is not
/// this tool's alone, and others may have taken it since the tool was rendered. `sharing`: who
/// holds what after the tick.
[[nodiscard]] inline bool is_shared(const ToolPlay& play, const StringSharing& sharing,
                                    const ContactKey& key) noexcept {
  if (!is_string(key)) return false;
  return static_cast<std::size_t>(key.obstacle) >= play.scene.obstacles.capsules_W.size() ||
         part_of(play.view, key.obstacle) != nullptr || is_held(sharing, key.obstacle);
}

/// A tool's view of a string, from tick to tick.
struct ToolStringState {
  double distance = 1.0;          ///< StringTouch::distance of the last tick, m; 1: not near
  Vector3 u_W{0.0, 0.0, 0.0};     ///< deflection, m
  Vector3 v_W{0.0, 0.0, 0.0};     ///< its rate over the last tick, m/s
  Vector3 nhat_W{0.0, 0.0, 0.0};  ///< along which its vibration has pushed the tool since
  /// Where its touch is told to be: the place from G, m, and the normal there.
  Vector3 p_GC_W{0.0, 0.0, 0.0};
  Vector3 told_nhat_W{0.0, 0.0, 0.0};
  /// Likewise in W after the tick that the touch was in last, of the part `left_part`: an end that
  /// is told later is there.
  Vector3 left_p_WC{0.0, 0.0, 0.0};
  Vector3 left_nhat_W{0.0, 0.0, 0.0};
  std::int32_t left_part = -1;
  std::int32_t part = -1;  ///< of the tool, that was nearest when one was near
  /// The touch, while another tool plays the string (PlayedString::player).
  ReleaseDetector detector;
};

/// What the simulation keeps of each string between ticks.
struct PlayedString {
  StringState state;        ///< its detector is that of the tool that plays it
  std::int32_t player = 0;  ///< the tool whose touch makes it sound or dampens it
  double place = 0.5;       ///< of that tool's last touch, along the string
};

/// Where a simulation keeps what it knows. Views must outlive it.
struct SimulationMemory {
  std::span<ToolPlay> tools;          ///< 1 to kMaxTools, their scenes set
  std::span<PlayedString> tracks;     ///< one per string, at most kMaxStrings
  std::span<ToolStringState> visits;  ///< one per string, of the first tool, then of the second...
  std::span<WaveMemory> waves{};      ///< one per string, or none when none sounds
  ContactSet* scratch = nullptr;      ///< null only with one tool
};

using StringTools = std::array<StringTool, kMaxTools>;

/// The tools of `memory` as the views of their strings are made from them; in `tools`.
[[nodiscard]] inline std::span<const StringTool> string_tools(const SimulationMemory& memory,
                                                              StringTools& tools) noexcept {
  for (std::size_t k = 0; k < memory.tools.size(); ++k) {
    ToolPlay& play = memory.tools[k];
    tools[k] = {&play.scene, &play.state, &play.view, memory.scratch};
  }
  return std::span(tools).first(memory.tools.size());
}

}  // namespace hapticd
