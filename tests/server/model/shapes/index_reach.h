// How deep the hand's index finger reaches: where scenes and tests set it down.
#pragma once

#include <cmath>

#include "server/model/shapes/hand_model.h"

namespace hapticd::test {

/// Depth of the lowest point of the index finger's pad below G's origin, m.
[[nodiscard]] inline double index_reach(const HandParameters& parameters) {
  const FingerPad pad = finger_pad(parameters, Finger::kIndex);
  return pad.R_G.row(1).transpose().cwiseProduct(pad.semi_axes).norm();
}

}  // namespace hapticd::test
