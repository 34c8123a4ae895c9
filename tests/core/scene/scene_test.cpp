// A built scene holds what its description says, where it says, and its simulations share nothing.
#include "core/scene/scene.h"

#include <doctest/doctest.h>

#include "core/math/rotation.h"
#include "core/scene/sagging_cable.h"
#include "core/scene/scene_check.h"
#include "tests/core/scene/scene_builder.h"
#include "tests/support/random.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

bool has_fault(const SceneDescription& scene, const std::string& path) {
  for (const SceneFinding& finding : check_scene(scene)) {
    if (!finding.doubt && finding.path == path) return true;
  }
  return false;
}

/// Heights of the tool over some ticks of a press on what is below.
std::vector<double> press(Simulation& simulation) {
  std::vector<double> heights;
  SimulationTick output;
  for (int tick = 1; tick <= 200; ++tick) {
    const HandPose sample{
        std::int64_t{1'000'000} * tick, {0.0, 0.01 - 1e-4 * tick, 0.0}, {1.0, 0.0, 0.0, 0.0}};
    output.step(simulation, sample);
    heights.push_back(output.tool(0).X_WG.p.y());
    heights.push_back(output.tool(0).F_H_W.f.y());
  }
  return heights;
}

}  // namespace

TEST_CASE("the parts of a tool become one tree, each where its pose puts it") {
  SceneDescription description = finger_scene();
  const Pose X_GP{exp_rotation({0.3, -0.2, 0.5}), {0.1, 0.2, 0.3}};
  description.tools[0].parts.push_back(
      part_of({{{0.01, 0.0, 0.0}, 1e-3}, {{0.0, 0.02, 0.0}, 2e-3}}, X_GP));
  description.tools[0].parts[1].softness = {2000.0, 1.0};
  const Scene scene(description);
  const ToolScene view = scene.tool_scene(0);
  REQUIRE(scene.tool_spheres(0) == 3);
  CHECK(view.tool.leaf(0).p == Vector3(0, 0, 0));
  CHECK((view.tool.leaf(1).p - transform(X_GP, {0.01, 0.0, 0.0})).norm() <= 1e-15);
  CHECK((view.tool.leaf(2).p - transform(X_GP, {0.0, 0.02, 0.0})).norm() <= 1e-15);
  CHECK(view.tool.leaf(2).r == 2e-3);
  CHECK(view.parts.part_of(0) == 0);
  CHECK(view.parts.part_of(1) == 1);
  CHECK(view.parts.part_of(2) == 1);
  REQUIRE(view.parts.parts.size() == 2);
  CHECK(view.parts.parts[1].stiffness == 2000.0);
}

TEST_CASE("strings come first among the capsules, pieces and corners know what they belong to") {
  SceneDescription description = finger_scene({0.0, 1.0, 0.0});
  description.strings.push_back(string_between({-1, 0, 0}, {1, 0, 0}));
  description.strings.push_back(string_between({-1, 0, 1}, {1, 0, 1}));
  description.strings[1].sag = 0.1;
  description.lines.push_back({"pipe", {{0, 0, 2}, {1, 0, 2}, {1, 1, 2}}, 0.01});
  const Scene scene(description);
  const auto pieces = static_cast<std::size_t>(cable_pieces(0.1));
  CHECK(scene.string_pieces() == 1 + pieces);
  const auto owners = scene.capsule_owners();
  REQUIRE(owners.size() == 1 + pieces + 2);
  CHECK((owners[0].is_string && owners[0].index == 0));
  for (std::size_t i = 1; i <= pieces; ++i) CHECK((owners[i].is_string && owners[i].index == 1));
  for (std::size_t i = 1 + pieces; i < owners.size(); ++i) {
    CHECK((!owners[i].is_string && owners[i].index == 0));
  }
  const ToolScene view = scene.tool_scene(0);
  CHECK(view.strings.size() == 1 + pieces);
  CHECK(view.obstacles.capsules_W.back().p_B == Vector3(1, 1, 2));
  CHECK(view.obstacles.groups.size() == (owners.size() + 15) / 16);
  CHECK(view.obstacles.bends.empty());
}

TEST_CASE("two simulations of a scene give the same bits and do not disturb each other") {
  SceneDescription description = finger_scene({0.0, 0.01, 0.0});
  description.strings.push_back(string_between({-0.5, 0, 0}, {0.5, 0, 0}));
  description.strings[0].parameters.frequency = 65.4;
  const Scene scene(description);
  const OwnedSimulation alone = scene.simulate(0);
  const std::vector<double> once = press(*alone.simulation);
  const OwnedSimulation first = scene.simulate(0);
  const OwnedSimulation second = scene.simulate(0);
  press(*first.simulation);
  CHECK(press(*second.simulation) == once);
}

TEST_CASE("without torque the device gets none, with it some") {
  for (const bool torque : {false, true}) {
    SceneDescription description = finger_scene();
    description.tools[0].parts = {part_of({{{0.03, 0.0, 0.0}, 5e-3}})};
    description.bodies.push_back({"ball", shape_of({{{0.03, -0.05, 0.0}, 0.04}}), {}});
    description.torque = torque;
    const Scene scene(description);
    const OwnedSimulation play = scene.simulate(0);
    SimulationTick output;
    for (int tick = 1; tick <= 100; ++tick) {
      output.step(*play.simulation,
                  {std::int64_t{1'000'000} * tick, {0.0, -2e-4 * tick, 0.0}, {1.0, 0.0, 0.0, 0.0}});
    }
    CHECK(output.tool(0).F_H_W.f.norm() > 0.5);
    CHECK((output.tool(0).F_H_W.t.norm() > 0.0) == torque);
  }
}

TEST_CASE("what no single number shows is found: tools, ids, parts, softness, starts inside") {
  SceneDescription none;
  CHECK(has_fault(none, "tools"));
  SceneDescription twins = finger_scene();
  twins.tools.push_back(twins.tools[0]);
  CHECK(has_fault(twins, "tools[1].tool_id"));
  twins.tools[1].tool_id = 1;
  CHECK(check_scene(twins).empty());
  SceneDescription crowd = finger_scene();
  for (std::uint32_t id = 1; id < 6; ++id) {
    CHECK(check_scene(crowd).empty());
    crowd.tools.push_back(crowd.tools[0]);
    crowd.tools.back().tool_id = id;
  }
  CHECK(has_fault(crowd, "tools"));
  SceneDescription partless = finger_scene();
  partless.tools[0].parts.clear();
  CHECK(has_fault(partless, "tools[0].parts"));
  SceneDescription hard = finger_scene();
  hard.tools[0].parts[0].softness.stiffness = -1.0;
  CHECK(has_fault(hard, "tools[0].parts[0].fingertip.stiffness_n_per_m"));
  SceneDescription inside = finger_scene();
  inside.bodies.push_back({"ball", shape_of({{{0.0, 0.0, 0.0}, 0.04}}), {}});
  REQUIRE(check_scene(inside).size() == 1);
  CHECK(check_scene(inside)[0].doubt);
  SceneDescription nan = finger_scene();
  nan.strings.push_back(string_between({0, 0, 0}, {1, 0, 0}));
  nan.strings[0].parameters.tension = std::numeric_limits<double>::quiet_NaN();
  CHECK(has_fault(nan, "strings[0].tension_n"));
}

}  // namespace hapticd::test
