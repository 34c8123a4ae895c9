// How steep the distance from a blended surface (blended_surface.h) is. Its gap grows by so much of
// the way along its normal; that to all else by all of it. RT: yes; about 0.2 us.
#pragma once

#include "core/collision/blended_surface.h"
#include "core/collision/query.h"

namespace hapticd {

/// Length of the gradient of phi at the tool's sphere, in [0, 1]; 1 where `key` is with no blended
/// surface.
[[nodiscard]] HD_REALTIME double blend_steepness(const ContactKey& key, const ToolView& tool,
                                                 const ObstaclesView& obstacles) noexcept;

/// The same at a point of the tree's frame. `memory` as in place_beside_blend().
[[nodiscard]] HD_REALTIME double steepness_beside_blend(const SphereTreeView& tree,
                                                        const Vector3& p_B,
                                                        LeavesAround* memory) noexcept;

}  // namespace hapticd
