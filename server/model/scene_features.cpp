// See scene_features.h.
#include "server/model/scene_features.h"

#include <algorithm>

namespace hapticd {
namespace {

/// Something a scene may have.
struct Feature {
  bool on;
  std::string with;
  std::string without;
};

/// What strings lie on, and what of bodies and lines is rough.
void add_touches(const SceneDescription& d, std::vector<Feature>& list) {
  const auto lies = [](const StringDescription& string) {
    return !string.touched_lines.empty() || !string.touched_bodies.empty();
  };
  const auto lying = std::count_if(d.strings.begin(), d.strings.end(), lies);
  list.push_back({lying > 0,
                  std::to_string(lying) + " of " + std::to_string(d.strings.size()) +
                      " strings lie on lines and bodies where they are pressed on them",
                  "strings on lines and bodies: they pass them; touch names what they lie on"});
  const auto rough = [](const auto& object) { return object.friction_coefficient > 0.0; };
  const auto rough_ones = std::count_if(d.bodies.begin(), d.bodies.end(), rough) +
                          std::count_if(d.lines.begin(), d.lines.end(), rough);
  list.push_back({d.instrument.friction && rough_ones > 0,
                  "friction of " + std::to_string(rough_ones) + " of " +
                      std::to_string(d.bodies.size() + d.lines.size()) + " bodies and lines",
                  "friction of bodies and lines"});
}

std::vector<Feature> features_of(const SceneDescription& d) {
  const InstrumentOptions& o = d.instrument;
  bool yields = false;
  bool rigid = false;
  for (const StringDescription& string : d.strings) {
    const bool one = string.parameters.model != StringContact::kStraight;
    yields = yields || one;
    rigid = rigid || !one;
  }
  std::vector<Feature> list;
  list.push_back({d.torque, "torque: the wrench has all six components",
                  "torque: forces alone are rendered; contact still turns the tool"});
  if (d.strings.empty()) {
    list.push_back({false, "", "strings: there are none, and nothing of them is computed"});
    return list;
  }
  if (yields) {
    list.push_back({true,
                    "strings that yield: bent by the exact law of Eq. 10 to 12; at most " +
                        std::to_string(kMaxDeflectingStrings) + " at once, further ones rigid",
                    ""});
  }
  if (rigid) {
    list.push_back({true,
                    "rigid strings: straight in contact, with the force of Eq. 10 to 13 for "
                    "the depth |F| / (kt k_s): what is seen is not bent",
                    ""});
  }
  list.push_back({o.vibration, "vibration: Eq. 9 after a release, never more energy than released",
                  "vibration: a released string is still at once"});
  list.push_back({o.vibration && o.modes > 0,
                  "waves of " + std::to_string(o.modes) + " modes in two planes, stepped " +
                      std::to_string(o.substeps) + " times a millisecond",
                  "modes beyond the fundamental, which holds 81 % of the energy of a pluck in the "
                  "middle and 21 % of one at a tenth of the string"});
  list.push_back({o.vibration && o.pitch_glide, "pitch glide with amplitude",
                  "pitch glide: the pitch does not depend on the amplitude"});
  list.push_back(
      {o.friction, "friction: Coulomb, one stick anchor per string",
       "friction: a finger slides along and across strings freely. Pressed straight down "
       "on one\n    that bends it stands as on a ridge, and the string slips round it"});
  add_touches(d, list);
  if (yields) {
    list.push_back({true,
                    "lateral force of strings that yield: all of their force is the gradient "
                    "of what they store",
                    ""});
  }
  if (rigid) {
    list.push_back({o.lateral_force, "lateral force of rigid strings, from unequal angles",
                    "lateral force of rigid strings: gliding along one may give energy, which "
                    "the limit at the device takes back"});
  }
  list.push_back({d.tones, "tones at release", "tones: none is sent"});
  return list;
}

}  // namespace

std::vector<std::string> modelled(const SceneDescription& scene) {
  std::vector<std::string> list{"contact of all six degrees of freedom"};
  for (const Feature& feature : features_of(scene)) {
    if (feature.on) list.push_back(feature.with);
  }
  return list;
}

std::vector<std::string> not_modelled(const SceneDescription& scene) {
  std::vector<std::string> list;
  for (const Feature& feature : features_of(scene)) {
    if (!feature.on) list.push_back(feature.without);
  }
  for (const ToolDescription& tool : scene.tools) {
    bool soft = false;
    for (const PartDescription& part : tool.parts) soft = soft || part.softness.stiffness > 0.0;
    if (!soft) list.push_back("soft parts: " + tool.name + " is rigid");
  }
  return list;
}

const char* string_tuning(const StringParameters& string) {
  if (derive_string(string).frequency <= 0.0) return "no pitch";
  return density_decides(string) ? "the pitch follows tension_n, the linear density holds"
                                 : "the pitch holds, the linear density follows tension_n";
}

PlayedShape played_shape(const ShapeDescription& shape, int level) {
  const MeasuredTree& file = *shape.tree;
  const auto coarse = static_cast<std::size_t>(level - 1);
  if (level > 0 && coarse < file.levels.size()) {
    return {static_cast<std::size_t>(file.levels[coarse].spheres), level,
            file.levels[coarse].outer};
  }
  return {file.tree.leaf_r.size(), 0, file.outer};
}

int shown_level(int level) noexcept { return level == kLeafLevel ? 0 : level; }

bool is_as_measured(const ContactOptions& options, const Quality& quality) noexcept {
  return options.sub_steps == quality.options.sub_steps &&
         options.stop_tolerance == quality.options.stop_tolerance &&
         options.rotation_step == quality.options.rotation_step;
}

}  // namespace hapticd
