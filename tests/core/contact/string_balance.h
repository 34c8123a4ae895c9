// Is a configuration of tool and strings in equilibrium? Judged without the contact problem: the
// pull of the coupling on the tool and of every string on its vertex, from its law in long double,
// must be balanced by forces along the normals of what touches, found anew by exhaustion, that only
// push. Strings along x; motions of the tool in the plane across them and its rotation about x,
// which slide no contact along a string. SI, frame W. Not RT.
#pragma once

#include <span>
#include <vector>

#include "tests/core/contact/string_law_truth.h"
#include "tests/core/contact/string_scenes.h"

namespace hapticd::test {

/// What to look at beside the state of the run.
struct BalanceScene {
  const RenderingScene& scene;
  std::vector<StringParameters> strings;
  std::vector<Sphere> body_W{};  ///< leaf spheres of all bodies
};

struct Balance {
  double residual = 0.0;            ///< unbalanced part of all forces over the pull of the hand
  int pairs = 0;                    ///< that touch
  std::vector<double> string_pull;  ///< |pull| of each string at its vertex, N
};

/// `X_WH` is where the hand was in the last tick of `run`.
[[nodiscard]] Balance balance_of(const BalanceScene& scene, const ToolRun& run, const Pose& X_WH);

}  // namespace hapticd::test
