// What a device may send at its worst: the rows of motion and of numbers in the table of extremes,
// as samples for extreme_scene. Frames: W. SI. Not RT.
#pragma once

#include <string>
#include <vector>

#include "core/tick/tick.h"

namespace hapticd::test {

struct ExtremeHand {
  std::string name;
  std::vector<HandPose> samples;
};

/// All of them, each from the open: ends of strings, hovering at depth 0, numbers that are none,
/// quaternions off unit and negated, jumps up to 1e6 m, strokes of 0.1 to 100 m/s from all sides,
/// turning alone and by half a turn, time that stands, jumps and goes back, presses 50 mm deep.
[[nodiscard]] std::vector<ExtremeHand> extreme_hands();

}  // namespace hapticd::test
