// The rows of scenes and of symmetry in the table of extremes (tests/EXTREMES.md), at every level
// of quality and with both models of a string. Truth: exhaustive search, symmetry, and what the
// hand's motion explains.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "core/scene/quality.h"
#include "tests/scenario/extremes/extreme_scene.h"
#include "tests/support/random.h"
#include "tests/support/simulation_tick.h"
#include "tests/truth/path_run.h"

namespace hapticd::test {
namespace {

/// What a tick that ends a linearisation sooner may differ by, N: kt of 1 kN/m times the stop
/// tolerance of the level, but no more than a force at rest may be off.
double end_of_tick(const Computation& computation) {
  constexpr double kStiffness = 1000.0;
  constexpr double kAtRest = 5e-3;
  return std::min(kStiffness * quality_of(computation.level).options.stop_tolerance, kAtRest);
}

HandPose sample_at(int tick, const Vector3& p, const Vector3& phi = Vector3::Zero()) {
  return {(tick + 1) * std::int64_t{1'000'000}, to_array(p), to_array(exp_rotation(phi))};
}

/// Presses and slides on a string at z = 0, with some turning.
HandPose playing(int tick) {
  const double t = 1e-3 * tick;
  return sample_at(tick, {0.3 + 0.1 * t, 8e-3 - 6e-3 * std::min(1.0, 4.0 * t), 3e-4 * t},
                   {1e-2 * t, 0.0, 0.0});
}

}  // namespace

TEST_CASE("at every quality sixty spheres at one place give the force of one") {
  for (const Computation& computation : all_computations()) {
    CAPTURE(computation.name());
    const Scene one(crowded_scene(computation, 1));
    const Scene many(crowded_scene(computation, 60));
    OwnedSimulation play_one = one.simulate();
    OwnedSimulation play_many = many.simulate();
    SimulationTick a;
    SimulationTick b;
    double largest = 0.0;
    double difference = 0.0;
    int iterations = 0;
    for (int tick = 0; tick < 600; ++tick) {
      a.step(*play_one.simulation, playing(tick));
      b.step(*play_many.simulation, playing(tick));
      difference =
          std::max(difference, (a.tool(0).F_computed_H_W.f - b.tool(0).F_computed_H_W.f).norm());
      largest = std::max(largest, a.tool(0).F_computed_H_W.f.norm());
      const ContactResult& work = b.tool(0).contact;
      iterations = std::max(iterations, work.qp_iterations / std::max(1, work.sub_steps));
    }
    // Rounding decides in which linearisation a tick ends, which the stop tolerance bounds.
    CHECK(difference <= end_of_tick(computation));
    CHECK(largest > 0.1);
    CHECK(iterations <= 3 * 60);
  }
}

TEST_CASE("at every quality the same samples give the same bits") {
  for (const Computation& computation : all_computations()) {
    CAPTURE(computation.name());
    const Scene scene(extreme_scene(computation));
    OwnedSimulation first = scene.simulate();
    OwnedSimulation second = scene.simulate();
    SimulationTick a;
    SimulationTick b;
    SplitMix64 random(11);
    bool same = true;
    for (int tick = 0; tick < 400; ++tick) {
      const Vector3 p(0.5, random.uniform(-5e-3, 2e-2), random.uniform(-0.09, 0.07));
      a.step(*first.simulation, sample_at(tick, p));
      b.step(*second.simulation, sample_at(tick, p));
      same = same && a.tool(0).F_H_W.f == b.tool(0).F_H_W.f &&
             a.tool(0).F_H_W.t == b.tool(0).F_H_W.t && a.tool(0).X_WG.p == b.tool(0).X_WG.p &&
             a.strings().size() == b.strings().size() && a.events().size() == b.events().size();
    }
    CHECK(same);
  }
}

TEST_CASE("at every quality a tool that begins inside comes out gently, and stays out") {
  for (const Computation& computation : all_computations()) {
    CAPTURE(computation.name());
    const Scene scene(extreme_scene(computation));
    for (const Vector3& p : {Vector3(0.8, -0.03, 0.0), Vector3(0.5, 0.0, 0.0),
                             Vector3(0.5, 0.0, -0.06), Vector3(0.5, 1e-3, 0.04)}) {
      OwnedSimulation play = scene.simulate();
      SimulationTick output;
      Pose X_before{{1, 0, 0, 0}, p};
      double fastest = 0.0;
      double force_growth = 0.0;
      double force_before = 0.0;
      bool recovered = false;
      for (int tick = 0; tick < 100; ++tick) {
        output.step(*play.simulation, sample_at(tick, p));
        const RenderedTool& now = output.tool(0);
        REQUIRE(now.F_H_W.f.allFinite());
        const bool recovering = now.contact.status == ContactStatus::kRecovering;
        recovered = recovered || recovering;
        if (recovering) fastest = std::max(fastest, (now.X_WG.p - X_before.p).norm());
        // Once it is out, a string that it presses rings, and is felt to.
        const double growth = now.F_H_W.f.norm() - force_before;
        if (recovering || !recovered) force_growth = std::max(force_growth, growth);
        force_before = now.F_H_W.f.norm();
        X_before = now.X_WG;
      }
      CHECK(recovered);
      CHECK(output.tool(0).contact.status != ContactStatus::kRecovering);
      CHECK(fastest <= 2.1e-3);
      CHECK(force_growth <= kRecoveryForceRate * 1e-3 + 1e-9);
    }
  }
}

TEST_CASE("at every quality a switch of contacts changes the force as the motion explains") {
  for (const Computation& computation : all_computations()) {
    CAPTURE(computation.name());
    const Scene scene(switching_scene(computation));
    OwnedSimulation play = scene.simulate();
    const double kt = play.simulation->scene(0).stiffness.kt;
    SimulationTick output;
    const auto sample = [](int tick) {
      const double t = 1e-3 * tick;
      const double y =
          0.0145 - 0.0025 * std::min(1.0, 5.0 * t) + 0.02 * std::max(0.0, 1.0 - 5.0 * t);
      return sample_at(tick, {0.055 * std::cos(3.0 * t), y, 1e-4}, {0, 0.05 * std::sin(2 * t), 0});
    };
    output.step(*play.simulation, sample(0));
    Vector3 before = output.tool(0).F_computed_H_W.f;
    double worst = 0.0;
    double largest = 0.0;
    for (int tick = 1; tick < 4000; ++tick) {
      output.step(*play.simulation, sample(tick));
      const Vector3 now = output.tool(0).F_computed_H_W.f;
      const double way = (to_vector(sample(tick).p_WH) - to_vector(sample(tick - 1).p_WH)).norm();
      worst = std::max(worst, (now - before).norm() / std::max(0.15, 1.1 * kt * way));
      largest = std::max(largest, now.norm());
      before = now;
    }
    CHECK(worst <= 1.0);
    CHECK(largest > 1.0);
  }
}

TEST_CASE("at every quality a trembling hand that hovers for ten seconds plays no tone") {
  for (const Computation& computation : all_computations()) {
    CAPTURE(computation.name());
    const Scene scene(crowded_scene(computation, 1));
    OwnedSimulation play = scene.simulate();
    SplitMix64 random(5);
    SimulationTick output;
    int tones = 0;
    for (int tick = 0; tick < 10'000; ++tick) {
      const double t = 1e-3 * tick;
      const double tremor = 1e-4 * std::sin(2.0 * kPi * 9.0 * t);
      const double encoder = 20e-6 * std::round(random.uniform(-1.0, 1.0));
      const double y = kTip + kStringRadius + tremor + encoder;
      output.step(*play.simulation, sample_at(tick, {0.3, y, 0.0}));
      for (const StringEvent& event : output.events()) {
        if (event.kind == StringEventKind::kTone) ++tones;
      }
    }
    CHECK(tones == 0);
  }
}

TEST_CASE("at every quality q and -q, and a scene a kilometre away, give the same force") {
  const Vector3 far(1000.0, -500.0, 200.0);
  for (const Computation& computation : all_computations()) {
    CAPTURE(computation.name());
    const Scene here(crowded_scene(computation, 3));
    SceneDescription moved = crowded_scene(computation, 3);
    moved.tools.front().X_WG.p += far;
    StringParameters& string = moved.strings.front().parameters;
    string.p_WA = to_array(Vector3(to_vector(string.p_WA) + far));
    string.p_WB = to_array(Vector3(to_vector(string.p_WB) + far));
    const Scene there(std::move(moved));
    OwnedSimulation plain = here.simulate();
    OwnedSimulation negated = here.simulate();
    OwnedSimulation away = there.simulate();
    SimulationTick a;
    SimulationTick b;
    SimulationTick c;
    double of_sign = 0.0;
    double of_place = 0.0;
    for (int tick = 0; tick < 600; ++tick) {
      const HandPose sample = playing(tick);
      a.step(*plain.simulation, sample);
      HandPose other = sample;
      for (double& part : other.q_WH) part = -part;
      b.step(*negated.simulation, other);
      other = sample;
      other.p_WH = to_array(Vector3(to_vector(sample.p_WH) + far));
      c.step(*away.simulation, other);
      const Vector3 f = a.tool(0).F_computed_H_W.f;
      of_sign = std::max(of_sign, (b.tool(0).F_computed_H_W.f - f).norm());
      of_place = std::max(of_place, (c.tool(0).F_computed_H_W.f - f).norm());
    }
    CHECK(of_sign <= 1e-12);
    CHECK(of_place <= end_of_tick(computation));
  }
}

}  // namespace hapticd::test
