// See full_scene.h.
#include "tests/server/scene_io/full_scene.h"

#include <google/protobuf/text_format.h>

#include <stdexcept>

namespace hapticd::test {

namespace {

constexpr const char* kFullScene = R"(name: "full"
description: "everything there is"
preset: PRESET_DEFLECTING
tools {
  tool_id: 3
  name: "pen"
  parts {
    name: "tip"
    shape { spheres { centre_m: [0, 0, 0, 0, 0.01, 0] radius_m: [0.005, 0.006] } }
    pose_gp { p_m: [0, 0, 0] q: [1, 0, 0, 0] }
    fingertip { stiffness_n_per_m: 2000 damping_n_s_per_m: 1 }
  }
  pose_wg { p_m: [0, 0.2, 0] q: [1, 0, 0, 0] }
  coupling { kt_n_per_m: 800 length_m: 0.03 damping_n_s_per_m: 0.5 }
  workspace {
    scale: 2
    pose_wd { p_m: [0, 0, 0] q: [1, 0, 0, 0] }
    mirror: MIRROR_X
    clutch_button: 1
    recentre_button: 2
  }
  force_gain: 0.5
}
tools {
  tool_id: 4
  name: "thumb"
  parts {
    name: "tip"
    shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } }
    fingertip { stiffness_n_per_m: 2000 }
  }
  pose_wg { p_m: [0.1, 0.2, 0] }
  coupling { kt_w_n_per_m: [500, 900, 700] kr_g_n_m_per_rad: [0.4, 0.8, 0.7] }
}
bodies {
  name: "ball"
  shape { spheres { centre_m: [0, 0, 0] radius_m: 0.05 } }
  pose_wb { p_m: [0, -0.1, 0] q: [1, 0, 0, 0] }
  friction_coefficient: 0.4
}
lines { name: "bar" points_w_m: [-1, -0.3, 0, 0, -0.3, 0, 1, -0.3, 0.2] radius_m: 0.01 friction_coefficient: 0.2 }
strings {
  name: "C2"
  p_wa_m: [-0.5, 0, 0]
  p_wb_m: [0.5, 0, 0]
  radius_m: 0.0005
  tension_n: 40
  youngs_modulus_pa: 2e11
  axial_stiffness_n: 13400
  linear_density_kg_per_m: 0.0023
  frequency_hz: 65.4
  tuning: TUNING_FREQUENCY
  decay_s: 1
  loss_n2_per_s: 0.003
  touch_decay_s: 0.05
  model: STRING_MODEL_RIGID
  k_s: 2
  contact_stiffness_n_per_m: 900
  inharmonicity: 0.0001
  friction_coefficient: 0.2
  max_level: STRING_LEVEL_WAVE
}
strings {
  name: "D2"
  p_wa_m: [-0.5, 0, 0.02]
  p_wb_m: [0.5, 0, 0.02]
  frequency_hz: 73.4
  k_s_from_device {
    reference_lambda: 0.4
    reference_tension_n: 30
    device_stiffness_n_per_m: 2000
  }
}
strings { name: "cable" p_wa_m: [-0.5, -0.5, 0] p_wb_m: [0.5, -0.5, 0] sag_m: 0.02 }
vibration { sleep_energy: 0.001 pitch_glide {} }
friction { coefficient: 0.3 anchor_stiffness_n_per_m: 700 }
lateral_force {}
torque {}
wave { modes: 16 substeps: 16 }
tones { level: TONE_LEVEL_FORCE reference_amplitude_m: 0.004 reference_force_n: 9 gain: 2 }
release { arm_deflection_m: 0.0002 release_gap_m: 0.0002 refractory_s: 0.03 }
quality { level: 2 }
solver {
  max_substeps: 30
  stop_step_m: 1e-7
  margin_m: 0.004
  skin_m: 1e-5
  max_rotation_rad: 0.04
  max_rows: 200
  tool_level: 2
  body_level: 3
  recovery_speed_m_per_s: 1
}
)";

}  // namespace

const std::string& full_scene_text() {
  static const std::string text = kFullScene;
  return text;
}

v1::Scene full_scene() {
  v1::Scene scene;
  if (!google::protobuf::TextFormat::ParseFromString(full_scene_text(), &scene)) {
    throw std::runtime_error("the full scene cannot be read");
  }
  return scene;
}

std::string print_scene(const v1::Scene& scene) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(scene, &text);
  return text;
}

LoadResult load_inline(const std::string& text) { return load_scene_text(text, {}); }

std::string list(const SceneProblems& problems) {
  std::string text;
  for (const SceneProblem& problem : problems) text += to_text(problem) + "\n";
  return text;
}

const SceneProblem* find_fault(const SceneProblems& problems, const std::string& path) {
  for (const SceneProblem& problem : problems) {
    if (!problem.doubt && problem.field == path) return &problem;
  }
  return nullptr;
}

}  // namespace hapticd::test
