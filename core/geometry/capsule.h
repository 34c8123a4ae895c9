// A capsule: all points within `r` of the segment AB. A string at rest, a rigid line, a pipe. A ==
// B is a sphere, r == 0 a bare segment; both are legal. RT: yes.
#pragma once

#include "core/math/vector.h"

namespace hapticd {

struct Capsule {
  Vector3 p_A{0.0, 0.0, 0.0};  ///< m
  Vector3 p_B{0.0, 0.0, 0.0};  ///< m
  double r = 0.0;              ///< m, >= 0
};

}  // namespace hapticd
