// A gesture ready to be played by the simulated hand: made outside the loop, lent to it by pointer,
// given back in a LoopEvent. RT: plain data for the loop.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "device/simulated/arm_model.h"
#include "device/simulated/gesture.h"

namespace hapticd {

/// Longest name of a gesture.
inline constexpr std::size_t kGestureNameCapacity = 64;

/// What the simulated hand is to do.
struct GesturePlan {
  std::array<char, kGestureNameCapacity + 1> name{};  ///< ends in 0
  GestureMotion motion;                               ///< in D; empty: ends what plays
  std::optional<ArmKind> arm;                         ///< none: as before
  std::optional<std::uint64_t> seed;                  ///< of the tremor; none: goes on
  std::uint32_t repeat = 1;                           ///< 0: until told otherwise
};

}  // namespace hapticd
