// The damping of a handle from how it rang against a known spring (ring_equations.h), with bounds.
// The lower one is what counts, so each thing that is not known is taken as it makes it lowest:
//  - a delay d acts like a damping of -k d: two stiffnesses tell it, and the shortest that is
//    plausible counts
//  - dry friction has a term of its own, and never helps
//  - a hand that holds on is a stiffness k_h that no free handle has. Above kMaxHold nothing is
//    told. Below, what it may damp is taken off: kHandTime times the largest k_h that is plausible
//  - each half of the rings must say the same, and the lowest counts
// What cannot be told from the device: something that damps the handle and is softer than kMaxHold
// all the same, with more than kHandTime of its stiffness, as a dashpot. No hand is that; whoever
// measures has to let the handle go. Frame: one axis of D. SI. Not RT: some milliseconds.
#pragma once

#include <cstdint>
#include <span>

#include "device/attach/ring_equations.h"

namespace hapticd {

/// Stiffness that is not the spring's, N/m, at most, so that a hand of 10 N/m is noticed with an
/// error to spare. Larger: one that hardly touches is not; smaller: no handle with a cable or a
/// coarse encoder can be measured.
inline constexpr double kMaxHold = 8.0;
/// Damping of a hand over its stiffness, s, at most: arms and fingers have hundreds of N/m for
/// some 10 N s/m. Larger: less is left of what was measured; smaller: a loose hand counts.
inline constexpr double kHandTime = 0.1;

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
