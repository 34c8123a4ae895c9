// What is plucked in a shipped scene sounds, once per string and in order, and what is not touched
// sleeps.
#include <doctest/doctest.h>

#include <numeric>
#include <set>

#include "tests/scenario/shipped_scene.h"
#include "tests/server/model/shapes/index_reach.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

/// Leads the tool's origin along a polyline at `speed`; collects the strings of the tones, and the
/// most strings that were awake at once.
struct Playing {
  OwnedSimulation play;
  Pose X_WH;
  std::int64_t t_ns = 0;
  std::vector<std::int32_t> tones;
  std::size_t most_awake = 0;
  SimulationTick output;

  explicit Playing(const Scene& scene)
      : play(scene.simulate(0)), X_WH(scene.description().tools[0].X_WG) {}

  void go(const Vector3& goal, double speed) {
    const Vector3 from = X_WH.p;
    const int ticks = static_cast<int>((goal - from).norm() / (1e-3 * speed)) + 1;
    for (int tick = 1; tick <= ticks; ++tick) {
      X_WH.p = from + (static_cast<double>(tick) / ticks) * (goal - from);
      t_ns += 1'000'000;
      output.step(*play.simulation, {t_ns, to_array(X_WH.p), to_array(X_WH.q)});
      for (const StringEvent& event : output.events()) {
        if (event.kind == StringEventKind::kTone) tones.push_back(event.string);
      }
      most_awake = std::max(most_awake, output.strings().size());
    }
  }
};

}  // namespace

TEST_CASE(
    "a finger across a hundred strings plucks each once, in order, while the far ones sleep") {
  const auto loaded = load_shipped("strings_100");
  Playing playing(*loaded->scene);
  playing.go({0.02, 0.03, -0.52}, 1.0);
  playing.go({0.02, 0.0045, -0.52}, 1.0);
  playing.most_awake = 0;
  // Slower, a finger leaves the highest strings over several periods, so gently that they are
  // still after it.
  playing.go({0.02, 0.0045, 0.52}, 0.8);
  std::vector<std::int32_t> all(100);
  std::iota(all.begin(), all.end(), 0);
  CHECK(playing.tones == all);
  playing.tones.clear();
  // Ten times the decay time later nothing is awake.
  playing.go({0.02, 0.3, 0.52}, 0.1);
  playing.go({0.02, 0.5, 0.52}, 0.05);
  CHECK(playing.tones.empty());
  CHECK(playing.output.strings().empty());
}

TEST_CASE("the index finger plucks each string of the Guqin, and rests on its body in between") {
  const auto loaded = load_shipped("guqin");
  const SceneDescription& d = loaded->scene->description();
  Playing playing(*loaded->scene);
  const double pad = index_reach({});
  for (std::size_t i = 0; i < d.strings.size(); ++i) {
    CAPTURE(i);
    const StringParameters& s = d.strings[i].parameters;
    const double lambda = 0.1;
    const Vector3 p = to_vector(s.p_WA) + lambda * (to_vector(s.p_WB) - to_vector(s.p_WA));
    playing.tones.clear();
    // Down beside the string, on the far side, and drawn towards the player across it.
    playing.go(p + Vector3(0, 0.03, -0.009), 0.5);
    playing.go(p + Vector3(0, pad - 0.0025, -0.009), 0.2);
    playing.go(p + Vector3(0, pad - 0.0025, 0.009), 0.2);
    playing.go(p + Vector3(0, 0.03, 0.009), 0.5);
    CHECK(std::set<std::int32_t>(playing.tones.begin(), playing.tones.end()) ==
          std::set<std::int32_t>{static_cast<std::int32_t>(i)});
  }
}

}  // namespace hapticd::test
