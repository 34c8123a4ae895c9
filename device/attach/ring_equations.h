// The rings of a handle against a known spring as equations that are linear in what is not known:
// m x'' + b x' + c sign(x') + k_h x = F(t - d) + F_0, with F(t - d) = F - d F', weighted by smooth
// windows that take the derivatives off the noisy positions (method of modulating functions,
// Shinbrot 1957). F is what was written, so what a sampled and held spring does needs no
// correction. The pull before a ring counts too: a hand that holds on shows best in where the
// handle comes to rest. Frame: one axis of D. SI. Not RT.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <span>
#include <vector>

namespace hapticd {

/// A tick of the measuring (core/tick/measuring_plan.h).
struct RingSample {
  double t_s = 0.0;  ///< since it began
  double x = 0.0;    ///< as sampled, m
  double f = 0.0;    ///< as written then, N
};

/// Places of the unknowns: m (kg), b (N s/m), c (N), F_0 (N), k_h (N/m), d (s).
enum RingUnknown : int { kMass, kDamping, kFriction, kOffset, kHold, kDelay, kRingUnknowns };
using RingVector = Eigen::Matrix<double, kRingUnknowns, 1>;

/// row . unknowns = force.
struct RingEquation {
  RingVector row = RingVector::Zero();
  double force = 0.0;
};

/// Of one ring, in the order of time.
struct RingEquations {
  std::vector<RingEquation> all;
  std::size_t overlap = 1;  ///< so many neighbours to either side share samples with one
};

/// The equations of `ring`, one ring with the pull before it in the order of time, with positions
/// from `x0`; none where it hardly moved. Windows in which the handle lies still are left out:
/// there dry friction may be anything.
[[nodiscard]] RingEquations equations_of(std::span<const RingSample> ring, double x0);

}  // namespace hapticd
