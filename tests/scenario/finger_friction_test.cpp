// The instruments that are shipped have a finger's friction: what is pressed is held.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "tests/scenario/shipped_scene.h"
#include "tests/server/model/shapes/index_reach.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

/// Coefficient of a finger's skin and how much it varies, as measured by Zhang and Mak (1999).
constexpr double kSkin = 0.46;
constexpr double kSkinVaries = 0.15;

/// Beside the middle of a string a finger presses, and how deep, m: what holds it there is 0.2 of
/// what it is pressed with, as of a pad of 5 mm, within the cone of friction.
constexpr double kBeside_m = 1e-3;
constexpr double kDeep_m = 6e-3;
/// The finger comes down in kDown ticks and rests for kRest.
constexpr int kDown = 500;
constexpr int kRest = 300;
/// A string pushes a finger it holds aside by less, m, and has pushed it by more where it slips.
constexpr double kHeld_m = 0.03e-3;
constexpr double kSlipped_m = 0.15e-3;

std::unique_ptr<Scene> without_friction(const Scene& scene) {
  SceneDescription description = scene.description();
  description.instrument.friction = false;
  return std::make_unique<Scene>(std::move(description));
}

/// How far string `number` has pushed the index finger aside that presses it beside its middle, m.
double pushed_aside(const Scene& scene, std::size_t number) {
  const SceneDescription& d = scene.description();
  const StringParameters& s = d.strings[number].parameters;
  const Vector3 p = to_vector(s.p_WA) + 0.19 * (to_vector(s.p_WB) - to_vector(s.p_WA));
  const OwnedSimulation play = scene.simulate(0);
  SimulationTick output;
  const Quaternion q = d.tools[0].X_WG.q;
  for (int tick = 1; tick <= kDown + kRest; ++tick) {
    const double share = std::min(1.0, static_cast<double>(tick) / kDown);
    const double above = s.radius + 0.005 - share * (0.005 + kDeep_m);
    const Vector3 p_WH = p + Vector3(0.0, index_reach({}) + above, kBeside_m);
    output.step(*play.simulation, {1'000'000LL * tick, to_array(p_WH), to_array(q)});
  }
  const RenderedTool& tool = output.tool(0);
  REQUIRE(tool.F_computed_H_W.f.y() > 0.1);
  return std::abs(tool.X_WG.p.z() - tool.X_WH.p.z());
}

}  // namespace

TEST_CASE("every string of the Guqin holds a finger as skin does") {
  for (const std::string name : {"five_fingers", "guqin", "guqin_coarse", "guqin_fine"}) {
    if (name == "guqin_fine" && !fine_models_exist()) continue;
    CAPTURE(name);
    const auto loaded = load_shipped(name);
    const SceneDescription& d = loaded->scene->description();
    CHECK(d.instrument.friction);
    for (const StringDescription& string : d.strings) {
      CHECK(std::abs(string.parameters.friction_coefficient - kSkin) <= kSkinVaries);
    }
  }
}

TEST_CASE("a string pressed beside its middle is held, and without friction it slips round") {
  const auto loaded = load_shipped("guqin");
  const auto smooth = without_friction(*loaded->scene);
  for (std::size_t k = 0; k < loaded->scene->description().strings.size(); ++k) {
    CAPTURE(k);
    const double held = pushed_aside(*loaded->scene, k);
    const double slipped = pushed_aside(*smooth, k);
    CHECK(held <= kHeld_m);
    CHECK(slipped >= kSlipped_m);
  }
}

}  // namespace hapticd::test
