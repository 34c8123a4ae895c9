// A sphere: the primitive every tool and body is made of. RT: yes.
#pragma once

#include "core/math/vector.h"

namespace hapticd {

struct Sphere {
  Vector3 p{0.0, 0.0, 0.0};  ///< centre, m, in the frame the holder states
  double r = 0.0;            ///< radius, m, >= 0
};

}  // namespace hapticd
