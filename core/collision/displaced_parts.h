// Parts of a tool that are displaced from where the rigid tool has them: soft fingertips under
// load. All spheres of a part are displaced alike; the tree stays as it was built. Frame: the
// tool's, G. RT: yes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/geometry/sphere_tree_view.h"

namespace hapticd {

/// Where a part is.
struct PartDisplacement {
  std::int32_t part;
  Vector3 v_G;  ///< m
};

/// The parts of a tool that are displaced, each once; none: the tool is as its tree says. Speaks of
/// leaves alone, so queries with displaced parts go down to them.
struct DisplacedParts {
  /// Part of each leaf of the tool's tree; empty: all are of part 0.
  std::span<const std::uint8_t> part_of_sphere{};
  std::span<const PartDisplacement> parts{};

  /// Index in `parts` of what displaces the leaf `sphere`, or -1.
  [[nodiscard]] int find(TreeSphereId sphere) const noexcept {
    const std::int32_t part =
        part_of_sphere.empty() ? 0 : part_of_sphere[static_cast<std::size_t>(sphere)];
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (parts[k].part == part) return static_cast<int>(k);
    }
    return -1;
  }
  /// Greatest displacement, m.
  [[nodiscard]] double greatest() const noexcept {
    double greatest = 0.0;
    for (const PartDisplacement& part : parts) greatest = std::max(greatest, part.v_G.norm());
    return greatest;
  }
};

}  // namespace hapticd
