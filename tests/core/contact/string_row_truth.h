// Where a rigid tool rests on many strings at once, each under a sphere of its own: the balance of
// the hand's coupling and of every string's law (string_law_truth.h) in six degrees of freedom,
// solved from the geometry by damped Newton steps with differences for derivatives. Shares no code
// with the contact problem. Strings along x. SI, frame W. Not RT.
#pragma once

#include <optional>
#include <vector>

#include "tests/core/contact/string_law_truth.h"
#include "tests/core/contact/string_scenes.h"

namespace hapticd::test {

/// Sphere number k is over string number k and touches no other.
struct StringRow {
  std::vector<StringParameters> strings;
  std::vector<Sphere> tool;
  CouplingStiffness stiffness;
  double skin = 20e-6;
};

struct RowRest {
  Vector3 p_WG;
  Vector3 phi_WG;             ///< rotation vector of G
  Wrench F_H_W;               ///< on the hand, about the origin of G
  std::vector<double> force;  ///< of each string, N
};

/// The rest at the hand's place `p_WH`, turned by `phi_WH`; none where no stable one was found: the
/// strings would let a tool without friction slip off.
[[nodiscard]] std::optional<RowRest> rest_on_row(const StringRow& row, const Vector3& p_WH,
                                                 const Vector3& phi_WH);

}  // namespace hapticd::test
