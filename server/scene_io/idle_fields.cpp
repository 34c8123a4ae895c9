// See idle_fields.h. Each rule repeats a condition of the code that would read the field.
#include "server/scene_io/idle_fields.h"

#include <algorithm>
#include <string>
#include <vector>

namespace hapticd {
namespace {

constexpr const char* kLeaveOut = "Leave it out, or change what it depends on.";

/// What a string can do in its scene.
struct Ability {
  bool bends = false;     ///< a press deflects it
  bool yields = false;    ///< a contact moves it
  bool rings = false;     ///< it sounds after a release
  bool in_modes = false;  ///< in more than its fundamental
};

Ability ability_of(const StringParameters& parameters, const InstrumentOptions& options) {
  const StringConstants string = derive_string(parameters);
  Ability ability;
  ability.bends = string.max_level >= StringDetail::kStatic;
  ability.yields = string.model == StringContact::kYielding;
  ability.rings =
      options.vibration && string.max_level >= StringDetail::kFundamental && string.frequency > 0.0;
  ability.in_modes = ability.rings && options.modes > 0 && string.max_level == StringDetail::kModes;
  return ability;
}

class IdleFields {
 public:
  IdleFields(const v1::Scene& written, const SceneDescription& scene)
      : written_(written), scene_(scene) {
    for (const StringDescription& string : scene.strings) {
      strings_.push_back(ability_of(string.parameters, scene.instrument));
    }
  }

  SceneProblems find() {
    features();
    tones();
    for (int i = 0; i < written_.strings_size(); ++i) string(i);
    solver();
    return std::move(found_);
  }

 private:
  void add(bool written, std::string path, const std::string& why, const char* remedy = kLeaveOut) {
    if (!written) return;
    found_.push_back({true, "", 0, 0, std::move(path), "this does nothing: " + why, remedy});
  }

  bool any(bool Ability::*what) const {
    return std::any_of(strings_.begin(), strings_.end(),
                       [what](const Ability& string) { return string.*what; });
  }

  /// Whether the scene is refused without what `level` needs.
  [[nodiscard]] bool asked(v1::StringLevel level) const {
    const auto& strings = written_.strings();
    return std::any_of(strings.begin(), strings.end(),
                       [level](const v1::String& each) { return each.max_level() >= level; });
  }

  void features();
  void ringing();
  void tones();
  void string(int i);
  void tuning(const v1::String& given, const Ability& able, const std::string& path);
  void solver();
  void levels(const std::string& nothing);

  const v1::Scene& written_;
  const SceneDescription& scene_;
  std::vector<Ability> strings_;
  SceneProblems found_;
};

void IdleFields::features() {
  const bool none = strings_.empty();
  const std::string no_string = "the scene has no string";
  add(none && written_.preset() != v1::PRESET_UNSPECIFIED, "preset", no_string);
  ringing();
  const bool rigid = !any(&Ability::bends);
  const std::string no_bend = none ? no_string : "no string bends";
  const auto rough = [](const auto& object) { return object.friction_coefficient() > 0.0; };
  const bool smooth = std::none_of(written_.bodies().begin(), written_.bodies().end(), rough) &&
                      std::none_of(written_.lines().begin(), written_.lines().end(), rough);
  add(written_.has_friction() && rigid && smooth, "friction", no_bend);
  const bool implied = written_.preset() != v1::PRESET_PAPER ||
                       std::none_of(strings_.begin(), strings_.end(), [](const Ability& string) {
                         return string.bends && !string.yields;
                       });
  add(written_.has_lateral_force() && (rigid || implied), "lateral_force",
      rigid ? no_bend
            : "a string that yields always has it, and one that does not outside of preset PAPER");
  // Of a string that does not bend, release_gap_m ends the touch.
  add(written_.has_release() && none, "release", no_string);
  add(written_.release().has_arm_deflection_m() && !none && rigid, "release.arm_deflection_m",
      no_bend);
}

void IdleFields::ringing() {
  const char* const tune = "A max_level needs it: tune its string by frequency_hz.";
  const std::string no_ring =
      strings_.empty()
          ? "the scene has no string"
          : "no string can ring; that takes a tuning, tension, length, and max_level FUNDAMENTAL "
            "or more";
  const bool waves = written_.has_wave() || written_.has_modes();
  const std::string wave = written_.has_wave() ? "wave" : "modes";
  const std::string both = "Leave it out together with " + wave + ", or change what it depends on.";
  add(written_.has_vibration() && !any(&Ability::rings), "vibration", no_ring,
      asked(v1::STRING_LEVEL_FUNDAMENTAL) ? tune
      : waves                             ? both.c_str()
                                          : kLeaveOut);
  const bool needed = asked(v1::STRING_LEVEL_WAVE);
  add(waves && !any(&Ability::in_modes), wave,
      !any(&Ability::rings) ? no_ring
      : needed              ? "no string of max_level WAVE can ring"
                            : "no string has max_level WAVE",
      needed ? tune : kLeaveOut);
}

void IdleFields::tones() {
  if (!written_.has_tones()) return;
  if (!any(&Ability::rings)) {
    const std::string still =
        scene_.instrument.vibration ? "no string can ring" : "without vibration no string rings";
    add(true, "tones", strings_.empty() ? "the scene has no string" : still);
    return;
  }
  const bool by_force = scene_.instrument.tones.level == ToneLevel::kForce;
  add(by_force && written_.tones().has_reference_amplitude_m(), "tones.reference_amplitude_m",
      "the level follows the force");
  add(!by_force && written_.tones().has_reference_force_n(), "tones.reference_force_n",
      "the level follows the amplitude");
}

void IdleFields::string(int i) {
  const v1::String& given = written_.strings(i);
  const Ability& able = strings_[static_cast<std::size_t>(i)];
  const std::string path = "strings[" + std::to_string(i) + "].";
  tuning(given, able, path);
  const bool scaled = given.displacement_scale_case() != v1::String::DISPLACEMENT_SCALE_NOT_SET;
  const char* const scale = given.has_k_s_from_device() ? "k_s_from_device" : "k_s";
  if (!able.bends) {
    const std::string rigid = "the string never bends";
    add(given.has_tension_n(), path + "tension_n", rigid);
    add(given.has_friction_coefficient(), path + "friction_coefficient", rigid);
    add(given.has_youngs_modulus_pa(), path + "youngs_modulus_pa", rigid);
    add(given.has_axial_stiffness_n(), path + "axial_stiffness_n", rigid);
    add(scaled, path + scale, rigid);
  } else {
    add(scaled && able.yields, path + scale,
        "it is of STRING_MODEL_RIGID alone, and this string yields");
    add(given.has_youngs_modulus_pa() && given.has_axial_stiffness_n(), path + "youngs_modulus_pa",
        "axial_stiffness_n wins");
  }
  const std::string no_modes = "the string does not ring in modes";
  add(given.inharmonicity() != 0.0 && !able.in_modes, path + "inharmonicity", no_modes);
  add(given.has_loss_n2_per_s() && !able.in_modes, path + "loss_n2_per_s", no_modes);
}

void IdleFields::tuning(const v1::String& given, const Ability& able, const std::string& path) {
  const bool both = given.has_linear_density_kg_per_m() && given.has_frequency_hz();
  const bool by_tension = given.tuning() == v1::TUNING_TENSION;
  add(both && !by_tension, path + "linear_density_kg_per_m", "frequency_hz wins");
  add(both && by_tension, path + "frequency_hz",
      "with TUNING_TENSION linear_density_kg_per_m wins");
  if (able.rings) return;
  const std::string still =
      scene_.instrument.vibration ? "the string cannot ring" : "the scene has no vibration";
  add(given.has_frequency_hz() && !(both && by_tension), path + "frequency_hz", still);
  add(given.has_linear_density_kg_per_m() && (!both || by_tension),
      path + "linear_density_kg_per_m", still);
  add(given.tuning() != v1::TUNING_UNSPECIFIED, path + "tuning", still);
  add(given.has_decay_s(), path + "decay_s", still);
  add(given.has_touch_decay_s(), path + "touch_decay_s", still);
}

/// Deepest tree of `shapes`.
template <typename List, typename ShapeOf>
int deepest(const List& list, const ShapeOf& shape_of) {
  int depth = 0;
  for (const auto& each : list) depth = std::max(depth, shape_of(each).tree->tree.depth);
  return depth;
}

/// The levels of trees at which descent stops; `nothing` says why there is nothing to descend to.
void IdleFields::levels(const std::string& nothing) {
  const v1::Solver& solver = written_.solver();
  int tools = 0;
  bool all_soft = true;
  for (const ToolDescription& tool : scene_.tools) {
    tools = std::max(tools, deepest(tool.parts, [](const auto& part) { return part.shape; }));
    all_soft = all_soft && std::any_of(tool.parts.begin(), tool.parts.end(), [](const auto& part) {
                 return part.softness.stiffness > 0.0;
               });
  }
  const int bodies = deepest(scene_.bodies, [](const auto& body) { return body.shape; });
  const auto level = [&](bool given, const char* path, std::uint32_t at, int depth) {
    const std::string why = !nothing.empty() ? nothing
                            : depth == 0     ? "the scene has no body"
                            : all_soft
                                ? "every tool has a soft part, and is then asked down to the leaves"
                                : "no tree is deeper than level " + std::to_string(depth);
    const bool idle = !nothing.empty() || all_soft || static_cast<int>(at) >= depth;
    add(given && idle, path, why);
  };
  level(solver.has_tool_level(), "solver.tool_level", solver.tool_level(), tools);
  level(solver.has_body_level(), "solver.body_level", solver.body_level(), bodies);
}

void IdleFields::solver() {
  const v1::Solver& solver = written_.solver();
  const bool empty = scene_.bodies.empty() && scene_.lines.empty() && strings_.empty();
  const std::string nothing = empty ? "the scene has nothing to touch" : "";
  levels(nothing);
  if (!empty) return;
  add(solver.has_max_substeps(), "solver.max_substeps", nothing);
  add(solver.has_stop_step_m(), "solver.stop_step_m", nothing);
  // margin_m shows: gaps are told up to it.
  add(solver.has_skin_m(), "solver.skin_m", nothing);
  add(solver.has_max_rotation_rad(), "solver.max_rotation_rad", nothing);
  add(solver.has_max_rows(), "solver.max_rows", nothing);
  add(solver.has_recovery_speed_m_per_s(), "solver.recovery_speed_m_per_s", nothing);
  for (int i = 0; i < written_.tools_size(); ++i) {
    for (int k = 0; k < written_.tools(i).parts_size(); ++k) {
      add(written_.tools(i).parts(k).has_fingertip(),
          "tools[" + std::to_string(i) + "].parts[" + std::to_string(k) + "].fingertip", nothing);
    }
  }
}

}  // namespace

SceneProblems idle_fields(const v1::Scene& written, const SceneDescription& scene) {
  return IdleFields(written, scene).find();
}

}  // namespace hapticd
