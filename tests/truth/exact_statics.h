// Where a tool rests that a hand holds against a scene, and what the hand feels, without a skin and
// without the program of core/contact:
//   minimise  kt/2 |p_WG - p_WH|^2 + kr/2 |log(R_WG R_HW)|^2 + energies of the strings
//   over the pose of G and a vertex per string, subject to gap >= 0 of every pair.
// Method: an augmented Lagrangian, each of its functions minimised by Newton's method with a line
// search, from a given start: what comes out is the rest that lies downhill of it. A string goes
// straight from its ends to one vertex; its energy is T ext + E A ext^2 / (2 L). Shares nothing
// with the product but data types. Frames: W. SI. Not RT: about 1 ms.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/capsule.h"
#include "core/geometry/sphere.h"
#include "core/math/pose.h"
#include "core/math/wrench.h"

namespace hapticd {

/// A string that yields.
struct StaticString {
  Capsule straight_W;
  double tension = 0.0;     ///< T, N
  double axial = 0.0;       ///< E A, N
  double compliance = 0.0;  ///< in series between vertex and string, m/N
};

/// What the tool can touch, and how it is held. The spans outlive it.
struct StaticScene {
  std::span<const Sphere> tool_G;
  std::span<const Sphere> bodies_W;
  std::span<const Capsule> lines_W;
  std::span<const StaticString> strings;
  double kt = 1000.0;      ///< N/m
  double length = 0.032;   ///< kr = kt length^2, m
  double fattening = 0.0;  ///< added to every tool sphere's radius, m: a control
};

/// A place of the tool and of the strings' vertices.
struct StaticPlace {
  Pose X_WG;
  std::vector<Vector3> vertices_W;  ///< one per string
};

/// A rest.
struct StaticRest {
  StaticPlace place;
  Wrench F_H_W;                ///< on the hand, about the origin of G
  double unbalanced = 0.0;     ///< largest force that is not balanced, N
  double entered = 0.0;        ///< deepest penetration of all pairs, m
  double complementary = 0.0;  ///< largest gap of a pair that bears force, m
};

/// True where the residuals are below 1e-6 N and 1e-9 m: what a comparison may rely on.
[[nodiscard]] bool converged(const StaticRest& rest) noexcept;

/// Straight strings, their vertices next to the tool.
[[nodiscard]] StaticPlace free_place(const StaticScene& scene, const Pose& X_WG);

/// The rest downhill of `start` for the hand at X_WH.
[[nodiscard]] StaticRest rest_from(const StaticScene& scene, const Pose& X_WH,
                                   const StaticPlace& start);

}  // namespace hapticd
