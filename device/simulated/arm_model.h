// The human arm behind the simulated device: mass, spring and damper toward a target, tremor, and
// the arm that works against us. Numbers as gesture.proto has them, with their sources. SI. RT:
// yes.
#pragma once

#include <array>
#include <cstddef>

#include "device/api/gesture_hand.h"

namespace hapticd {

inline constexpr std::size_t kArmKinds = 4;

/// Equal in all axes.
struct ArmModel {
  double mass = 0.0;                  ///< moves with the handle, kg
  double stiffness = 0.0;             ///< toward the target, N/m
  double damping = 0.0;               ///< toward the target, N s/m
  double inertia = 0.0;               ///< kg m^2
  double rotational_stiffness = 0.0;  ///< N m/rad
  double rotational_damping = 0.0;    ///< N m s/rad
  double tremor = 0.0;                ///< root mean square of the target's, m
  double tremor_frequency = 9.0;      ///< its centre, Hz
  double delay = 0.0;                 ///< until the adversarial arm reacts, s
  const char* source = "";            ///< where the numbers come from
};

/// Usual numbers of each kind, index kind - 1.
using ArmModels = std::array<ArmModel, kArmKinds>;
[[nodiscard]] const ArmModels& usual_arms() noexcept;

/// `kind`, or kOff where it is a number that no kind has: then nobody holds the handle.
[[nodiscard]] constexpr ArmKind known_arm(ArmKind kind) noexcept {
  return kind >= ArmKind::kOff && kind <= ArmKind::kAdversarial ? kind : ArmKind::kOff;
}

/// Index of a kind in ArmModels; that of known_arm().
[[nodiscard]] constexpr std::size_t index_of(ArmKind kind) noexcept {
  return static_cast<std::size_t>(known_arm(kind)) - 1;
}

}  // namespace hapticd
