// Soft parts of a tool: a fingertip that yields. A part may stand aside of where the rigid tool has
// it; surfaces never overlap, it is the part as drawn that moves. The displacement turns with the
// tool: it has the axes of G. SI. RT: yes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/collision/contact.h"
#include "core/collision/displaced_parts.h"
#include "core/instrument/parameter_range.h"
#include "core/math/fixed_vector.h"
#include "core/math/limits.h"
#include "core/math/realtime.h"

namespace hapticd {

/// What a part of a tool is made of. Names and ranges of scene.proto's Fingertip.
struct ToolPart {
  double stiffness = 0.0;  ///< k, N/m, [1, 1e9]; 0: rigid
  double damping = 0.0;    ///< c, N s/m, [0, 1e6]
};

/// The first fault of `part`, none when all is well. Non-finite numbers are out of range. 10 ns.
[[nodiscard]] HD_REALTIME std::optional<ParameterFault> check_part(const ToolPart& part) noexcept;

/// The parts of a tool. Views must outlive their use.
struct ToolParts {
  std::span<const ToolPart> parts{};  ///< at most 256; none: all is rigid
  /// Part of each leaf of the tool's tree; empty: all are of part 0.
  std::span<const std::uint8_t> part_of_sphere{};

  /// Part of the leaf `sphere`.
  [[nodiscard]] std::int32_t part_of(TreeSphereId sphere) const noexcept {
    return part_of_sphere.empty() ? 0 : part_of_sphere[static_cast<std::size_t>(sphere)];
  }
};

/// True when a part yields; queries then go by the leaves.
[[nodiscard]] inline bool any_soft(const ToolParts& tool) noexcept {
  for (const ToolPart& part : tool.parts) {
    if (part.stiffness > 0.0) return true;
  }
  return false;
}

/// A part that is touched or displaced, from tick to tick.
struct SoftPart {
  std::int32_t part = 0;
  Vector3 v_G{0.0, 0.0, 0.0};         ///< where it stands, m
  Vector3 v_before_G{0.0, 0.0, 0.0};  ///< where it stood when the tick began, m
};

/// In the order in which they were touched.
using TouchedParts = FixedVector<SoftPart, kMaxSoftParts>;

/// A part's motion in a step, in the axes of W and of G, m.
struct PartMotion {
  Vector3 dv_W;
  Vector3 dv_G;
};

/// Entries beyond the parts at hand mean nothing.
using PartMotions = std::array<PartMotion, kMaxSoftParts>;

/// Index among `soft` of the part that the leaf `sphere` belongs to, or -1.
[[nodiscard]] inline int find_part(const ToolParts& tool, const TouchedParts& soft,
                                   TreeSphereId sphere) noexcept {
  if (soft.empty()) return -1;
  const std::int32_t part = tool.part_of(sphere);
  for (std::size_t k = 0; k < soft.size(); ++k) {
    if (soft[k].part == part) return static_cast<int>(k);
  }
  return -1;
}

/// Greatest displacement of the parts, m: so much further than its tree does the tool reach.
[[nodiscard]] inline double greatest_displacement(const TouchedParts& soft) noexcept {
  double greatest = 0.0;
  for (const SoftPart& part : soft) greatest = std::max(greatest, part.v_G.norm());
  return greatest;
}

/// Where the parts stand as the collision stage wants it, after `fraction` of their motion where
/// one is given. Views what it is made from.
class ToolShape {
 public:
  ToolShape(const ToolParts& tool, const TouchedParts& soft) noexcept
      : part_of_sphere_(tool.part_of_sphere) {
    for (const SoftPart& part : soft) add(part.part, part.v_G);
  }
  ToolShape(const ToolParts& tool, const TouchedParts& soft, const PartMotions& motions,
            double fraction) noexcept
      : part_of_sphere_(tool.part_of_sphere) {
    for (std::size_t k = 0; k < soft.size(); ++k) {
      add(soft[k].part, soft[k].v_G + fraction * motions[k].dv_G);
    }
  }
  /// Valid as long as this.
  [[nodiscard]] DisplacedParts view() const noexcept {
    return {part_of_sphere_, {displaced_.data(), count_}};
  }

 private:
  void add(std::int32_t part, const Vector3& v_G) noexcept {
    if (v_G.x() != 0.0 || v_G.y() != 0.0 || v_G.z() != 0.0) displaced_[count_++] = {part, v_G};
  }

  std::span<const std::uint8_t> part_of_sphere_;
  std::array<PartDisplacement, kMaxSoftParts> displaced_;
  std::size_t count_ = 0;
};

}  // namespace hapticd
