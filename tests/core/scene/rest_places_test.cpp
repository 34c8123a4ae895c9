// Where strings can lie, against the distance of points along string and line by exhaustion, and
// what scenes may not ask for. Blended bodies: the equation of their surface, by halving over all
// spheres.
#include "core/scene/rest_places.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "core/scene/scene.h"
#include "core/scene/scene_check.h"
#include "tests/core/scene/scene_builder.h"
#include "tests/support/random.h"
#include "tests/support/within.h"
#include "tests/truth/contact_oracle.h"

namespace hapticd::test {
namespace {

SceneDescription with_line(const Vector3& p, const Vector3& q, double radius) {
  SceneDescription scene = finger_scene({0.0, 0.5, 0.0});
  scene.strings.push_back(string_between({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}));
  scene.lines.push_back({"fret", {p, q}, radius, 0.0});
  scene.strings[0].touched_lines = {0};
  return scene;
}

/// The first finding about what string 0 touches: 'f' a fault, 'd' a doubt, '-' none.
char judged(const SceneDescription& scene) {
  for (const SceneFinding& finding : check_scene(scene)) {
    if (finding.path == "strings[0].touch") return finding.doubt ? 'd' : 'f';
  }
  return '-';
}

}  // namespace

TEST_CASE("a line that crosses a string is touched where the two are nearest") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int scene = 0; scene < 200; ++scene) {
    CAPTURE(scene);
    const double x = random.uniform(0.1, 0.9);
    const Vector3 p(x, -random.uniform(4e-3, 20e-3), -0.05);
    const Vector3 q(x + random.uniform(-0.05, 0.05), -random.uniform(4e-3, 20e-3), 0.05);
    const double radius = random.uniform(0.0, 2e-3);
    const SceneDescription description = with_line(p, q, radius);
    double least = 1.0;
    double at = 0.0;
    for (int i = 0; i <= 2000; ++i) {
      const Vector3 there = p + i / 2000.0 * (q - p);
      const double distance = std::hypot(there.y(), there.z());
      if (distance < least) at = there.x();
      least = std::min(least, distance);
    }
    const Scene built(description);
    const auto rests = built.tool_scene(0).rests;
    REQUIRE(rests.size() == 1);
    CHECK(rests[0].lambda == within(at, 1e-3));
    const double gap = least - radius - description.strings[0].parameters.radius;
    CHECK((rests[0].p_W - Vector3(rests[0].lambda, 0.0, 0.0)).norm() == within(gap, 1e-4));
    CHECK(rests[0].nhat_W.y() > 0.0);
  }
}

TEST_CASE("a string that touches nothing has no place to lie, and costs nothing") {
  SceneDescription scene = with_line({0.5, -5e-3, -0.1}, {0.5, -5e-3, 0.1}, 1e-3);
  scene.strings[0].touched_lines.clear();
  CHECK(Scene(scene).tool_scene(0).rests.empty());
  CHECK(judged(scene) == '-');
}

TEST_CASE("a line far from the string is doubted, one that the string goes through is refused") {
  CHECK(judged(with_line({0.5, -5e-3, -0.1}, {0.5, -5e-3, 0.1}, 1e-3)) == '-');
  CHECK(judged(with_line({0.5, -0.2, -0.1}, {0.5, -0.2, 0.1}, 1e-3)) == 'd');
  CHECK(judged(with_line({0.5, 0.0, -0.1}, {0.5, 0.0, 0.1}, 1e-3)) == 'f');
  CHECK(judged(with_line({0.5, -0.5e-3, -0.1}, {0.5, -0.5e-3, 0.1}, 2e-3)) == 'f');
  // It lies on a bridge that is a little too high.
  CHECK(judged(with_line({0.5, -1.2e-3, -0.1}, {0.5, -1.2e-3, 0.1}, 1e-3)) == '-');
}

TEST_CASE("a capo that presses the string on a fret is refused with where the string would end") {
  // Its lower side is 1.5 mm below that of the straight string; the fret is 2 mm below it.
  SceneDescription scene = with_line({0.3, -4e-3, -0.1}, {0.3, -4e-3, 0.1}, 1e-3);
  const double radius = scene.strings[0].parameters.radius;
  scene.lines[0].points_W = {{0.3, -2e-3 - radius - 1e-3, -0.1}, {0.3, -2e-3 - radius - 1e-3, 0.1}};
  scene.lines.push_back(
      {"capo",
       {{0.29, 5e-3 + radius - 1.5e-3, -0.1}, {0.29, 5e-3 + radius - 1.5e-3, 0.1}},
       5e-3,
       0.0});
  scene.strings[0].touched_lines = {0, 1};
  const std::vector<SceneFinding> findings = check_scene(scene);
  REQUIRE(findings.size() == 1);
  CHECK_FALSE(findings[0].doubt);
  CHECK(findings[0].path == "strings[0].touch");
  CHECK(findings[0].message ==
        "capo presses the string 1.5 mm towards fret, but a string is straight at rest");
  CHECK(findings[0].remedy ==
        "Let the string end on fret, p_wa_m or p_wb_m: [0.3, -0.002, 0], with the pitch of the "
        "part that is left, and leave capo out of touch.");
  // One that stands clear of it, or has nothing under it, presses nothing on anything.
  for (Vector3& p : scene.lines[1].points_W) p.y() += 2e-3;
  CHECK(judged(scene) == '-');
  for (Vector3& p : scene.lines[1].points_W) p.y() -= 2e-3;
  scene.strings[0].touched_lines = {1};
  REQUIRE(judged(scene) == 'f');
  CHECK(check_scene(scene)[0].message == "at rest the string is 1.5 mm inside capo");
}

TEST_CASE("a cable that sags lies on nothing, and a rigid string never comes to lie") {
  SceneDescription sags = with_line({0.5, -5e-3, -0.1}, {0.5, -5e-3, 0.1}, 1e-3);
  sags.strings[0].sag = 0.01;
  CHECK(judged(sags) == 'f');
  SceneDescription rigid = with_line({0.5, -5e-3, -0.1}, {0.5, -5e-3, 0.1}, 1e-3);
  rigid.strings[0].parameters.model = StringContact::kStraight;
  CHECK(judged(rigid) == 'd');
}

TEST_CASE("a bar along a string is touched all along") {
  const SceneDescription scene = with_line({0.2, -5e-3, 0.0}, {0.6, -5e-3, 0.0}, 1e-3);
  const Scene built(scene);
  const auto rests = built.tool_scene(0).rests;
  REQUIRE(rests.size() > 50);
  for (const StringRest& rest : rests) {
    CHECK(rest.lambda >= 0.2);
    CHECK(rest.lambda <= 0.6);
    CHECK(rest.surface);
    CHECK(rest.p_W.y() == doctest::Approx(-4e-3 + scene.strings[0].parameters.radius));
  }
}

TEST_CASE("on a body whose spheres blend a string lies on the surface that tools touch") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int body = 0; body < 10; ++body) {
    CAPTURE(body);
    SceneDescription scene = finger_scene({0.0, 0.5, 0.0});
    scene.strings.push_back(string_between({0.0, 0.0, 0.0}, {0.2, 0.0, 0.0}));
    std::vector<Sphere> leaves;
    for (double x = 0.0; x <= 0.2; x += 5e-3) {
      for (double z = -0.02; z <= 0.02; z += 5e-3) {
        leaves.push_back({{x, -0.02 + random.uniform(-0.5e-3, 0.5e-3), z}, 8e-3});
      }
    }
    const double width = random.uniform(1e-3, 4e-3);
    auto tree = std::make_shared<MeasuredTree>();
    tree->tree = build_sphere_tree(leaves);
    blend_surface(width, tree->tree);
    ShapeDescription board;
    board.tree = tree;
    board.exact = true;
    scene.bodies.push_back({"board", board, {}});
    scene.strings[0].touched_bodies = {0};
    const double radius = scene.strings[0].parameters.radius;
    const std::vector<OracleBody> bodies{{leaves, Pose{}, width}};
    const Scene built(scene);
    const auto rests = built.tool_scene(0).rests;
    REQUIRE(rests.size() > 90);
    for (const StringRest& rest : rests) {
      const std::vector<Sphere> string{{{0.0, 0.0, 0.0}, radius}};
      const Pose X_WS{Quaternion::Identity(), rest.p_W};
      CHECK(std::abs(exhaustive_minimum_gap(string, X_WS, {{}, bodies})) <= 2e-6L);
    }
  }
}

}  // namespace hapticd::test
