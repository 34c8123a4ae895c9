// Paths judged against closed forms: one sphere against one line, a sphere on a body, a bent
// string; and that a path that tunnels is seen.
#include "tests/truth/path_judge.h"
#include "tests/support/within.h"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/scene/scene.h"
#include "core/tree/sphere_tree.h"
#include "tests/core/scene/scene_builder.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/truth/path_run.h"

namespace hapticd::test {
namespace {

constexpr double kFinger = 5e-3;
constexpr double kString = 0.34e-3;

/// A finger of one sphere over a string along x and a ball of 20 mm at z = 0.1 m.
SceneDescription string_and_ball() {
  SceneDescription scene = finger_scene({0.0, 0.05, 0.0});
  scene.strings.push_back(string_between({-0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}));
  scene.strings[0].parameters.radius = kString;
  BodyDescription ball;
  ball.name = "ball";
  ball.shape = shape_of({{{0.0, 0.0, 0.0}, 0.02}});
  ball.X_WB.p = {0.0, 0.0, 0.1};
  scene.bodies.push_back(ball);
  return scene;
}

ContactState at(const Vector3& p) {
  ContactState state;
  state.X_WG.p = p;
  return state;
}

/// Distance of the origin from the segment p q of a plane.
double distance_to_way(double px, double py, double qx, double qy) {
  const double dx = qx - px;
  const double dy = qy - py;
  const double square = dx * dx + dy * dy;
  const double s = square > 0.0 ? std::clamp(-(px * dx + py * dy) / square, 0.0, 1.0) : 0.0;
  return std::hypot(px + s * dx, py + s * dy);
}

}  // namespace

TEST_CASE("the gaps at a pose are those of the closed form, and no more than a millimetre") {
  const Scene scene(string_and_ball());
  PathJudge judge(scene.tool_scene(0));
  const ObstacleGaps over = judge.gaps(at({0.1, kFinger + kString + 3e-4, 0.0}));
  CHECK(over.capsules[0] == within(3e-4, 1e-9));
  CHECK(over.bodies[0] == kFarthestGap);
  const ObstacleGaps beyond = judge.gaps(at({0.5 + kFinger + kString - 2e-4, 0.0, 0.0}));
  CHECK(beyond.capsules[0] == within(-2e-4, 1e-9));
  const ObstacleGaps ball = judge.gaps(at({0.0, 0.02 + kFinger - 1e-4, 0.1}));
  CHECK(ball.capsules[0] == kFarthestGap);
  CHECK(ball.bodies[0] == within(-1e-4, 1e-9));
}

TEST_CASE(
    "between two balls that blend a finger is judged by the surface that they make together") {
  constexpr double kBlend = 4e-3;
  constexpr double kAside = 8e-3;
  MeasuredTree file;
  file.tree =
      build_sphere_tree(std::vector<Sphere>{{{kAside, 0, 0}, 0.02}, {{-kAside, 0, 0}, 0.02}});
  blend_surface(kBlend, file.tree);
  SceneDescription description = finger_scene({0.0, 0.05, 0.0});
  BodyDescription balls;
  balls.name = "balls";
  balls.shape.exact = true;
  balls.shape.tree = std::make_shared<const MeasuredTree>(std::move(file));
  balls.X_WB.p = {0.0, 0.0, 0.1};
  description.bodies.push_back(balls);
  const Scene scene(description);
  PathJudge judge(scene.tool_scene(0));
  // Equal distances d: 2 (1 - (d - phi) / w)^3 = 1.
  const double lower = kBlend * (1.0 - std::cbrt(0.5));
  for (const double gap : {3e-4, 9e-4, 1.2e-3}) {
    const double y = std::sqrt(std::pow(0.02 + kFinger + gap, 2) - kAside * kAside);
    const ContactState there = at({0.0, y, 0.1});
    CHECK(judge.gaps(there).bodies[0] == within(gap - lower, 1e-9));
    const std::vector<ContactState> resting{there, there};
    CHECK(judge.smallest_gap(resting) == within(gap - lower, 1e-9));
  }
}

TEST_CASE("the depth of a path into a line is that of its nearest point") {
  const Scene scene(string_and_ball());
  PathJudge judge(scene.tool_scene(0));
  SplitMix64 random(7);
  for (int k = 0; k < scaled(2000); ++k) {
    const double angle = random.uniform(0.0, 6.283185307179586);
    const double length = std::pow(10.0, random.uniform(-5.0, -1.3));
    const double y = random.uniform(-8e-3, 8e-3);
    const double z = random.uniform(-8e-3, 8e-3);
    const double y_to = y + length * std::cos(angle);
    const double z_to = std::min(z + length * std::sin(angle), 0.06);
    const std::vector<ContactState> path{at({0.1, y, z}), at({0.1, y_to, z_to})};
    const double truth = distance_to_way(y, z, y_to, z_to) - kFinger - kString;
    const double found = judge.smallest_gap(path);
    // Sphere tracing stops a quarter of the smallest thing short at most.
    const double spacing = (kFinger + kString) / 4.0;
    const double depth = kFinger + kString;
    const double error = depth - std::sqrt(std::max(0.0, depth * depth - spacing * spacing));
    if (truth >= 0.0) {
      REQUIRE(found >= std::min(truth, kFarthestGap) - 1e-12);
    } else {
      REQUIRE(found >= truth - 1e-12);
      REQUIRE(found <= truth + spacing);
      if (truth < -error) REQUIRE(found < 0.0);
    }
  }
}

TEST_CASE("a path that tunnels through a string within one step is seen") {
  const Scene scene(string_and_ball());
  PathJudge judge(scene.tool_scene(0));
  // Both ends are free, and 0.2 m apart: as at 200 m/s.
  const std::vector<ContactState> path{at({0.1, 0.1, 0.0}), at({0.1, -0.1, 0.0})};
  CHECK(judge.gaps(path.front()).capsules[0] == kFarthestGap);
  CHECK(judge.gaps(path.back()).capsules[0] == kFarthestGap);
  CHECK(judge.smallest_gap(path) < -0.7 * (kFinger + kString));
}

TEST_CASE("a string that is held bent is where its legs are") {
  const Scene scene(string_and_ball());
  PathJudge judge(scene.tool_scene(0));
  ContactState state = at({0.0, -5e-3 + kFinger + kString + 1e-4, 0.0});
  TouchedString hold;
  hold.yields = true;
  hold.bend.lambda = 0.5;
  hold.bend.u_W = {0.0, -5e-3, 0.0};
  REQUIRE(state.touched.push_back(hold));
  // Above the vertex of two legs the nearest point is the vertex or on a leg, 5 mm in 0.5 m.
  const double h = kFinger + kString + 1e-4;
  const double truth = h * std::cos(std::atan(5e-3 / 0.5)) - kFinger - kString;
  CHECK(judge.gaps(state).capsules[0] == within(truth, 1e-9));
  const std::vector<ContactState> resting{state, state};
  CHECK(judge.smallest_gap(resting) == within(truth, 1e-9));
}

TEST_CASE("a finger that is pressed on a string never goes into it, and one put there does") {
  const Scene scene(string_and_ball());
  PathRun run(scene);
  double smallest = kFarthestGap;
  for (int k = 0; k <= 100; ++k) {
    smallest =
        std::min(smallest, run.judged_tick({{1.0, 0.0, 0.0, 0.0}, {0.1, 0.05 - 6e-4 * k, 0.0}}));
  }
  CHECK(smallest >= -1e-9);
  CHECK(smallest < 1e-4);
  CHECK(run.touched().count("string") == 1);
  PathRun wrong(scene);
  wrong.place({{1.0, 0.0, 0.0, 0.0}, {0.1, 4e-3, 0.0}});
  CHECK(wrong.judged_tick({{1.0, 0.0, 0.0, 0.0}, {0.1, 4e-3, 0.0}}) ==
        within(4e-3 - kFinger - kString, 1e-9));
}

}  // namespace hapticd::test
