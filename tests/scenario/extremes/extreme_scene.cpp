// See extreme_scene.h.
#include "tests/scenario/extremes/extreme_scene.h"

#include <utility>

#include "core/scene/quality.h"
#include "tests/core/scene/scene_builder.h"

namespace hapticd::test {
namespace {

StringDescription string_of(const Computation& computation, const Vector3& p_WA,
                            const Vector3& p_WB, double radius) {
  StringDescription string;
  string.name = "string";
  string.parameters = default_string(computation.preset);
  string.parameters.p_WA = to_array(p_WA);
  string.parameters.p_WB = to_array(p_WB);
  string.parameters.radius = radius;
  string.parameters.frequency = 98.0;
  string.parameters.friction_coefficient = 0.4;
  return string;
}

SceneDescription empty_scene(const Computation& computation, const std::vector<Sphere>& tool) {
  SceneDescription scene = finger_scene({0.5, 0.05, 0.0});
  scene.tools.front().parts.front() = part_of(tool);
  scene.instrument = default_options(computation.preset);
  if (computation.preset == StringPreset::kDeflecting) {
    scene.instrument.friction = true;
    scene.instrument.lateral_force = true;
    scene.instrument.pitch_glide = true;
    scene.instrument.modes = 4;
  }
  scene.tones = true;
  scene.torque = true;
  scene.contact = quality_of(computation.level).options;
  scene.quality_level = static_cast<std::uint32_t>(computation.level);
  return scene;
}

LineDescription line_of(const Vector3& p_A, const Vector3& p_B, double radius) {
  return {.name = "line", .points_W = {p_A, p_B}, .radius = radius};
}

BodyDescription body_of(const std::vector<Sphere>& spheres, const Vector3& p_WB) {
  BodyDescription body;
  body.name = "body";
  body.shape = shape_of(spheres);
  body.X_WB.p = p_WB;
  return body;
}

/// A tip below, levers to the sides.
std::vector<Sphere> jack() {
  return {{{0.0, 0.0, 0.0}, kTip},
          {{0.03, 0.01, 0.0}, 2e-3},
          {{-0.03, 0.01, 0.0}, 2e-3},
          {{0.0, 0.01, 0.03}, 1e-4},
          {{0.0, 0.01, -0.03}, 1e-2}};
}

}  // namespace

std::string Computation::name() const {
  return (preset == StringPreset::kPaper ? "paper, level " : "deflecting, level ") +
         std::to_string(level);
}

std::vector<Computation> all_computations() {
  std::vector<Computation> all;
  for (int level = 0; level < kQualityLevels; ++level) {
    all.push_back({level, StringPreset::kPaper});
    all.push_back({level, StringPreset::kDeflecting});
  }
  return all;
}

SceneDescription extreme_scene(const Computation& computation) {
  SceneDescription scene = empty_scene(computation, jack());
  const auto add = [&](const Vector3& p_WA, const Vector3& p_WB, double radius) {
    scene.strings.push_back(string_of(computation, p_WA, p_WB, radius));
  };
  add({0.0, 0.0, kUsualZ}, {1.1, 0.0, kUsualZ}, kStringRadius);
  add({0.0, 0.0, 0.02}, {1.1, 0.0, 0.02}, 0.0);
  add({0.0, 0.0, 0.0400}, {1.1, 0.0, 0.0400 + 1e-7}, kStringRadius);
  add({0.0, 0.0, 0.0401}, {1.1, 0.0, 0.0401 - 1e-7}, kStringRadius);
  add({0.0, 0.0, 0.06}, {1.1, 0.0, 0.06}, kStringRadius);
  scene.strings.back().parameters.tension = 0.0;
  scene.strings.back().parameters.youngs_modulus = 0.0;
  scene.strings.back().parameters.frequency = 0.0;
  add({0.5, 0.0, -0.02}, {0.500001, 0.0, -0.02}, kStringRadius);
  add({0.5, 0.0, -0.04}, {0.5, 0.0, -0.04}, kStringRadius);
  add({0.49, 0.0, -0.06}, {0.51, 0.0, -0.06}, 2e-3);
  scene.lines.push_back(line_of({0.5, 0.0, -0.08}, {0.5, 0.0, -0.08}, 1e-3));
  std::vector<Sphere> plate;
  for (int i = -8; i <= 8; ++i) {
    for (int k = -8; k <= 8; ++k) plate.push_back({{5e-3 * i, 0.0, 5e-3 * k}, 5e-3});
  }
  scene.bodies.push_back(body_of(plate, {0.8, -0.03, 0.0}));
  return scene;
}

SceneDescription switching_scene(const Computation& computation) {
  SceneDescription scene =
      empty_scene(computation, {{{0, 0, 0}, 8e-3}, {{0.012, 0, 0}, 8e-3}, {{-0.012, 0, 0}, 8e-3}});
  scene.tools.front().X_WG.p = {0.055, 0.03, 1e-4};
  scene.lines.push_back(line_of({-0.3, 0.0, 0.0}, {0.3, 0.0, 0.0}, 3e-3));
  std::vector<Sphere> pillar;
  for (int k = -50; k <= 0; ++k) pillar.push_back({{0.0, 2e-3 * k, 0.0}, 8e-3});
  scene.bodies.push_back(body_of(pillar, {0.05, 0.0, 0.0}));
  scene.strings.push_back(
      string_of(computation, {-0.05, 0.003, -0.4}, {-0.05, 0.003, 0.6}, kStringRadius));
  return scene;
}

SceneDescription crowded_scene(const Computation& computation, int spheres) {
  SceneDescription scene = empty_scene(
      computation, std::vector<Sphere>(static_cast<std::size_t>(spheres), {{0, 0, 0}, kTip}));
  scene.tools.front().X_WG.p = {0.3, 0.02, 0.0};
  scene.strings.push_back(string_of(computation, {0.0, 0.0, 0.0}, {1.1, 0.0, 0.0}, kStringRadius));
  return scene;
}

}  // namespace hapticd::test
