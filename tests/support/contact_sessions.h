// Scripted motions of a haptic tool through small scenes: what the accuracy of the renderer is
// judged on. A smooth tool of many contacts is pressed on one line, on two, between a line and a
// pillar, carried from one to the other, and twisted in a wedge until it slips. SI, frame W: y up,
// lines along x. Not RT.
#pragma once

#include <vector>

#include "core/geometry/capsule.h"
#include "core/geometry/sphere.h"
#include "core/math/vector.h"

namespace hapticd::test {

/// Spheres of a body in its own frame, whose axes are those of W.
struct SessionBody {
  std::vector<Sphere> spheres_B;
  Vector3 p_WB;
};

/// Pose of the haptic tool: position (m) and rotation vector (rad).
struct SessionPose {
  Vector3 p_WH;
  Vector3 phi_WH;
};

struct ContactSession {
  const char* name;
  std::vector<Sphere> tool_G;
  std::vector<Capsule> capsules_W;
  std::vector<SessionBody> bodies;
  double seconds;
  SessionPose (*X_WH)(double t);  ///< t in [0, seconds]; free of contact at 0
};

[[nodiscard]] ContactSession single_press();
[[nodiscard]] ContactSession two_lines();
[[nodiscard]] ContactSession line_and_pillar();
[[nodiscard]] ContactSession contact_switch();
[[nodiscard]] ContactSession twisted_wedge();

/// All of the above, in this order.
[[nodiscard]] std::vector<ContactSession> contact_sessions();

}  // namespace hapticd::test
