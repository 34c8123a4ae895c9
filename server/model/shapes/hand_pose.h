// The skeleton of the hand: joints and radii of the plucking pose, as round cones. Of a right hand
// 0.18 m long, in a frame at the wrist: y up, fingers along -z, palm down, thumb at x < 0. Internal
// to this folder. Offline.
#pragma once

#include <array>
#include <vector>

#include "server/model/shapes/hand_model.h"
#include "server/model/shapes/implicit_shape.h"

namespace hapticd {

/// A finger from its knuckle to the tip.
struct FingerBones {
  std::vector<RoundCone> cones;
  FingerPad pad;
};

struct HandBones {
  std::vector<RoundCone> palm;
  std::array<FingerBones, kFingers> fingers;
};

/// In m.
[[nodiscard]] HandBones hand_bones();

}  // namespace hapticd
