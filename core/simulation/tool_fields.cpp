// See tool_fields.h.
#include "core/simulation/tool_fields.h"

namespace hapticd {
namespace {

bool names_sphere(const SphereTreeView& tree, TreeSphereId id) noexcept {
  if (id >= 0) return static_cast<std::size_t>(id) < tree.leaf_x.size();
  const auto slot = static_cast<std::size_t>(-(id + 1));
  return slot / kTreeWidth < tree.nodes.size();
}

bool names_pair(const ContactKey& key, const ToolScene& scene) noexcept {
  if (key.obstacle < 0 || !names_sphere(scene.tool, key.tool_sphere)) return false;
  const auto obstacle = static_cast<std::size_t>(key.obstacle);
  if (is_string(key)) {
    return obstacle < scene.obstacles.capsules_W.size() && key.obstacle_sphere >= 0 &&
           key.obstacle_sphere <= 1;
  }
  return obstacle < scene.obstacles.bodies.size() &&
         names_sphere(scene.obstacles.bodies[obstacle].tree, key.obstacle_sphere);
}

}  // namespace

bool fits_scene(const ToolState& state, const ToolScene& scene) noexcept {
  const ContactState& contact = state.contact;
  for (int k = 0; k < contact.active_count; ++k) {
    if (!names_pair(contact.active[static_cast<std::size_t>(k)].key, scene)) return false;
  }
  std::int32_t before = -1;
  for (const TouchedString& hold : contact.touched) {
    const StringBend& bend = hold.bend;
    if (bend.capsule <= before || static_cast<std::size_t>(bend.capsule) >= scene.strings.size() ||
        !(bend.lambda >= 0.0 && bend.lambda <= 1.0)) {
      return false;
    }
    before = bend.capsule;
  }
  for (const SoftPart& part : contact.parts) {
    if (part.part < 0 || static_cast<std::size_t>(part.part) >= scene.parts.parts.size()) {
      return false;
    }
  }
  return true;
}

}  // namespace hapticd
