// The rows of motion and of numbers in the table of extremes (tests/EXTREMES.md), at every level of
// quality and with both models of a string. Truth: exhaustive search along the committed path, and
// the limits of the device.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/scene/quality.h"
#include "tests/scenario/extremes/extreme_hands.h"
#include "tests/scenario/extremes/extreme_scene.h"
#include "tests/support/guarded_step.h"
#include "tests/support/scale.h"
#include "tests/truth/path_run.h"

namespace hapticd::test {
namespace {

/// Deepest path allowed, m.
constexpr double kAllowedDepth = 1e-6;

bool finite(const SimulationTick& output) {
  const RenderedTool& tick = output.tool(0);
  bool all = tick.F_H_W.f.allFinite() && tick.F_H_W.t.allFinite() &&
             tick.F_computed_H_W.f.allFinite() && tick.X_WG.p.allFinite() &&
             tick.X_WG.q.coeffs().allFinite();
  for (const StringTick& reading : output.strings()) {
    all = all && std::isfinite(reading.radius_growth) && std::isfinite(reading.vibration_force) &&
          to_vector(reading.deflection_W).allFinite();
  }
  for (const StringEvent& event : output.events()) {
    all = all && std::isfinite(event.amplitude) && std::isfinite(event.level);
  }
  return all;
}

}  // namespace

TEST_CASE("whatever a device sends, at every quality the wrench is finite, limited, 0 on a fault") {
  const std::vector<ExtremeHand> hands = extreme_hands();
  for (const Computation& computation : all_computations()) {
    const Scene scene(extreme_scene(computation));
    for (const ExtremeHand& hand : hands) {
      CAPTURE(computation.name());
      CAPTURE(hand.name);
      OwnedSimulation play = scene.simulate();
      const ToolScene& settings = play.simulation->scene(0);
      GuardedHand guarded;
      SimulationTick output;
      double largest = 0.0;
      for (const HandPose& sample : hand.samples) {
        const PoseVerdict verdict = guarded_step(sample, guarded, *play.simulation, output);
        REQUIRE(finite(output));
        const RenderedTool& tick = output.tool(0);
        const bool faulty = verdict == PoseVerdict::kFault;
        REQUIRE((!faulty || (tick.F_H_W.f.norm() == 0.0 && tick.F_H_W.t.norm() == 0.0)));
        largest = std::max({largest, tick.F_H_W.f.norm() / settings.limits.force,
                            tick.F_H_W.t.norm() / settings.limits.torque});
      }
      CHECK(largest <= 1.0 + 1e-12);
    }
  }
}

TEST_CASE("whatever a device sends, at every quality the tool's path enters nothing") {
  const std::vector<ExtremeHand> hands = extreme_hands();
  for (const Computation& computation : all_computations()) {
    // Exhaustive search takes long under a sanitizer: there the usual level stands for all.
    if (test_scale() < 0.1 && computation.level != kDefaultQuality) continue;
    const Scene scene(extreme_scene(computation));
    for (const ExtremeHand& hand : hands) {
      CAPTURE(computation.name());
      CAPTURE(hand.name);
      PathRun run(scene);
      run.place({{1, 0, 0, 0}, to_vector(hand.samples.front().p_WH)});
      GuardedHand guarded;
      HandMotion motion;
      double smallest = kFarthestGap;
      for (const HandPose& sample : hand.samples) {
        if (guarded.take(sample) == PoseVerdict::kFault) break;
        const double dt_s = follow(guarded.hand(), motion);
        smallest = std::min(smallest, run.judged_tick(motion.X_WH, dt_s));
      }
      CHECK(smallest >= -kAllowedDepth);
    }
  }
}

}  // namespace hapticd::test
