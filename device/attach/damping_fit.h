// The damping of a handle from how it rang against a known spring: m x'' + b x' + k_h x + c
// sign(x') = F + F_0 with the forces that were written, weighted by smooth windows that take the
// derivatives off the noisy positions (method of modulating functions, Shinbrot 1957), then least
// squares. That the forces are known takes in what a sampled spring does: its hold needs no
// correction. A delay d makes it act like a damping of -k d, so the lower bound counts no delay at
// all and the upper one the longest. Dry friction has a term of its own, and a hand that holds on
// is a stiffness k_h that no handle has; two stiffnesses of the spring tell both from mass. Frame:
// one axis of D. SI. Not RT: some milliseconds.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd {

/// A tick of the measuring (core/tick/measuring_plan.h).
struct RingSample {
  double t_s = 0.0;  ///< since it began
  double x = 0.0;    ///< as sampled, m
  double f = 0.0;    ///< as written then, N
};

/// What is known of a handle's damping. All finite, 0 < lower <= upper, 0 < mass.
struct DampingBounds {
  double lower = 0.0;  ///< N s/m
  double upper = 0.0;  ///< N s/m
  double mass = 0.0;   ///< estimate, kg
};

/// How a measuring ended.
enum class RingVerdict : std::uint8_t {
  kMeasured,
  kNoRing,     ///< it hardly moved, or stood still again at once
  kHeld,       ///< something held on to it
  kUnclear,    ///< it does not move as a mass with damping and dry friction
  kTooLittle,  ///< no damping that could be counted
  kMoved,      ///< led away from where it was
  kLimited,    ///< force, heat or energy limits interfered
  kCut,        ///< the force went off, the clutch was opened, or the scene was changed
  kTicksLost,  ///< samples are missing
};

struct DampingFit {
  RingVerdict verdict = RingVerdict::kNoRing;
  DampingBounds bounds;  ///< of kMeasured
};

/// `samples`: in the order of their time. `delay_s`: longest from sample to force, >= 0.
[[nodiscard]] DampingFit fit_damping(std::span<const RingSample> samples, double delay_s);

}  // namespace hapticd
