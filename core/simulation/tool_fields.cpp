// See tool_fields.h.
#include "core/simulation/tool_fields.h"

namespace hapticd {

bool fits_scene(const ToolState& state, const ToolScene& scene) noexcept {
  const ContactState& contact = state.contact;
  for (int k = 0; k < contact.active_count; ++k) {
    const ContactKey& key = contact.active[static_cast<std::size_t>(k)].key;
    if (!has_sphere(scene.tool, key.tool_sphere) || !has_obstacle(key, scene.obstacles)) {
      return false;
    }
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
  for (const Grip& grip : contact.grips) {
    if (!has_obstacle({grip.kind, grip.obstacle, 0, 0}, scene.obstacles)) return false;
  }
  for (const SoftPart& part : contact.parts) {
    if (part.part < 0 || static_cast<std::size_t>(part.part) >= scene.parts.parts.size()) {
      return false;
    }
  }
  return true;
}

}  // namespace hapticd
