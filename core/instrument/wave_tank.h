// Bounds what a string that sounds gives to hands beyond its static law: that alone is the device
// loop's. What is held against the hand's way fills the tank, what the static law lets go of at a
// pluck does too, and no more is ever in it than the string has beyond the static law. Source:
// S. Stramigioli, "Energy-aware robotics", 2015. SI; across the string. RT: yes, 20 ns per tool.
#pragma once

#include <span>

#include "core/instrument/wave_state.h"

namespace hapticd {

/// A string may give this much that nobody has put in, J: noise of a hand on a string at rest.
inline constexpr double kTankReserve = 5e-6;

/// One tool in a tick.
struct WavePort {
  std::size_t tool = 0;
  Transverse moved;     ///< way of the hand at the contact over the tick, m
  double slid = 0.0;    ///< and along the string, m
  Transverse law;       ///< static force on the tool, N
  double pull = 0.0;    ///< and along the string, N
  Transverse felt;      ///< mean force on the tool, N
  double stored = 0.0;  ///< by the static law, in string and coupling, J
  Transverse way;       ///< of the hand until the next tick, if it goes on as it does, m
  double aside = 0.0;   ///< and by how much it may differ, m
};

/// Books the tick of all tools that are near, or were in the last tick. `spare` (J): what the
/// string has beyond its static law.
HD_REALTIME void settle_wave_tank(std::span<const WavePort> ports, double spare,
                                  WaveTank& tank) noexcept;

/// Shares out what is in it, and what a string lends that rings with `ringing` (J): what each port
/// may add to its static force, N, in their order. Kept as what the next tick is booked by.
HD_REALTIME void draw_wave_forces(std::span<const WavePort> ports, double ringing,
                                  std::span<Transverse> beyond, WaveTank& tank) noexcept;

}  // namespace hapticd
