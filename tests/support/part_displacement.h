// How far a soft part has given way, as the page would draw it.
#pragma once

#include <cstdint>

#include "core/contact/configuration_optimiser.h"

namespace hapticd::test {

/// Where part number `part` is drawn from its place in the rigid tool at X_WG, in W, m.
[[nodiscard]] inline Vector3 part_displacement(const OptimiserState& state, std::int32_t part) {
  for (const SoftPart& soft : state.parts) {
    if (soft.part == part) return state.X_WG.q * soft.v_G;
  }
  return {0.0, 0.0, 0.0};
}

}  // namespace hapticd::test
