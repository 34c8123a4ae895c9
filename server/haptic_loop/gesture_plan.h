// A gesture ready to be played by the simulated hands: made outside the loop and lent to it
// (LoopChannels). RT: plain data for the loop.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "device/api/gesture_hand.h"

namespace hapticd {

/// Longest name of a gesture.
inline constexpr std::size_t kGestureNameCapacity = 64;

/// What the simulated hands are to do.
struct GesturePlan {
  std::array<char, kGestureNameCapacity + 1> name{};  ///< ends in 0
  /// Of each tool in the scene's order, in D of its device; empty or missing: that hand rests.
  std::vector<GestureMotion> motions;
  std::optional<ArmKind> arm;         ///< none: as before
  std::optional<std::uint64_t> seed;  ///< of the tremor of tool 0, others count on; none: goes on
  std::uint32_t repeat = 1;           ///< 0: until told otherwise
};

}  // namespace hapticd
