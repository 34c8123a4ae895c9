// The law for tools with soft parts: nothing sinks into anything, judged on the way of the tool,
// its parts and the strings between committed configurations, with the parts' spheres where they
// are drawn.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/contact/strokes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Allowed depth of the committed path, m.
constexpr long double kAllowedDepth = 1e-6L;

/// Splits the tool into up to seven parts, rigid ones and soft ones, with dampers and without.
void soften(SplitMix64& random, RenderingScene& scene) {
  const std::uint64_t parts = 1 + random.below(7);
  for (std::uint64_t k = 0; k < parts; ++k) {
    const double stiffness = std::pow(10.0, random.uniform(0.0, 6.0));
    const double damping = random.chance(0.5) ? std::pow(10.0, random.uniform(-3.0, 3.0)) : 0.0;
    scene.parts.push_back({random.chance(0.2) ? 0.0 : stiffness, damping});
  }
  for (std::size_t k = 0; k < scene.tool_spheres.size(); ++k) {
    scene.part_of_sphere.push_back(static_cast<std::uint8_t>(random.below(parts)));
  }
}

/// The law on the strokes that `make` makes of seeds from `first_seed` on, with softened tools.
void check_strokes(Stroke (*make)(std::uint64_t), std::uint64_t first_seed) {
  const std::int64_t strokes = scaled(20'000);
  long double deepest = 1.0L;
  std::int64_t displaced_ticks = 0;
  for (std::int64_t i = 0; i < strokes; ++i) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
    Stroke stroke = make(seed);
    SplitMix64 random(seed);
    soften(random, stroke.scene);
    ToolRun run(stroke.scene, stroke.X_WH.front());
    long double gap = 1.0L;
    for (const Pose& X_WH : stroke.X_WH) {
      gap = std::min(gap, run.tick_along(X_WH));
      displaced_ticks += greatest_displacement(run.state.parts) > 1e-6 ? 1 : 0;
    }
    deepest = std::min(deepest, gap);
    if (gap < -kAllowedDepth) {
      FAIL_CHECK("stroke " << seed << ": " << static_cast<double>(gap) << " m, "
                           << stroke.describe());
    }
  }
  MESSAGE("deepest point of " << strokes << " committed paths: " << static_cast<double>(deepest)
                              << " m, " << displaced_ticks << " ticks with a part displaced");
  CHECK(deepest >= -kAllowedDepth);
  CHECK(displaced_ticks > strokes / 4);
}

}  // namespace

TEST_CASE("no stroke makes a tool with soft parts sink into anything by more than a micrometre") {
  check_strokes(make_stroke, 30'000'000);
}

TEST_CASE("no stroke makes a tool with soft parts sink into strings that yield") {
  check_strokes(make_string_stroke, 40'000'000);
}

}  // namespace hapticd::test
