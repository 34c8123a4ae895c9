// What a tool knows of a rigid object that it rubs on. Frames: W. SI. RT: yes, plain data.
#pragma once

#include <cstdint>
#include <span>

#include "core/collision/obstacles.h"
#include "core/math/fixed_vector.h"
#include "core/math/vector.h"

namespace hapticd {

/// Rigid objects whose friction one tool feels at once, at most.
inline constexpr std::size_t kMaxGrips = 16;

/// A touched object with friction, from tick to tick.
struct Grip {
  ObstacleKind kind{};
  std::int32_t obstacle = 0;      ///< index among those of its kind
  double normal_force = 0.0;      ///< of the object on the tool after the last program, N
  Vector3 slip_W{0.0, 0.0, 0.0};  ///< of the anchor's spring, tangential, m
};

/// Ordered by nothing in particular.
using Grips = FixedVector<Grip, kMaxGrips>;

/// Coulomb coefficients of what is rigid, [0, 10], in the order of the obstacles; empty: smooth.
struct RigidCoefficients {
  std::span<const double> capsules{};  ///< of all; those of strings are not read
  std::span<const double> bodies{};

  [[nodiscard]] bool none() const noexcept { return capsules.empty() && bodies.empty(); }
  [[nodiscard]] double of(ObstacleKind kind, std::int32_t obstacle) const noexcept {
    const std::span<const double> all = kind == ObstacleKind::kBody ? bodies : capsules;
    const auto index = static_cast<std::size_t>(obstacle);
    return index < all.size() ? all[index] : 0.0;
  }
};

}  // namespace hapticd
