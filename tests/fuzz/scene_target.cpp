// See scene_target.h.
#include "tests/fuzz/scene_target.h"

#include <stdexcept>

#include "server/scene_io/scene_loader.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

void require(bool condition) {
  if (!condition)
    throw std::logic_error("a scene was taken that cannot be played, or refused without a reason");
}

}  // namespace

bool check_scene_bytes(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const LoadResult result = load_scene_text(text, {});
  if (result.loaded == nullptr) {
    require(any_fault(result.problems));
    for (const SceneProblem& problem : result.problems) require(!problem.message.empty());
    return false;
  }
  const Scene& scene = *result.loaded->scene;
  const OwnedSimulation play = scene.simulate(0);
  const WrenchLimits limits = scene.tool_scene(0).limits;
  const Pose& start = scene.description().tools[0].X_WG;
  SimulationTick output;
  for (int tick = 0; tick < 5; ++tick) {
    HandPose sample{std::int64_t{1'000'000} * tick, to_array(start.p), to_array(start.q)};
    sample.p_WH[1] -= 2e-3 * tick;
    output.step(*play.simulation, sample);
    const Wrench& F = output.tool(0).F_H_W;
    require(F.f.norm() <= limits.force * (1.0 + 1e-12));
    require(F.t.norm() <= limits.torque * (1.0 + 1e-12));
  }
  return true;
}

}  // namespace hapticd::test
