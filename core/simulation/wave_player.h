// Plays a string that sounds (core/instrument/wave_string.h) among all tools: where each of them
// meets it, one solve for all, what it adds to their wrenches, its events and its row of the tick.
// The contact problem of each tool has its static law, which the string keeps to when it is still;
// what it does beyond that is paid by its tank. Frames: W. SI. RT: yes; 4 us per string under one
// tool, nothing for one that rings untouched but a reading every 50 ms.
#pragma once

#include "core/simulation/tool_play.h"
#include "core/tick/string_event.h"

namespace hapticd {

/// One string of a simulation.
struct PlayedWave {
  const SimulationMemory& memory;
  const StringSharing& sharing;
  std::int32_t string;  ///< its number
};

/// True of a string that this scene lets sound on this rung.
[[nodiscard]] HD_REALTIME bool is_wave(const SimulationMemory& memory,
                                       std::int32_t string) noexcept;

/// One tick. Adds to the wrenches of the tools, to tick.strings and to `events`.
HD_REALTIME void play_wave(const PlayedWave& wave, Tick& tick, StringEvents& events) noexcept;

/// How far it swings from its straight line at most, m; 0: it is still.
[[nodiscard]] HD_REALTIME double wave_swing(const SimulationMemory& memory,
                                            std::int32_t string) noexcept;

/// Makes it silent at once, and says so.
HD_REALTIME void silence_wave(const PlayedWave& wave, StringEvents& events) noexcept;

/// Silent, and touched by nobody: forgets what it did.
HD_REALTIME void end_wave(WaveMemory& wave) noexcept;

}  // namespace hapticd
