// A tool that moves among more strings than the dense program has room for: nothing is entered,
// nothing jumps as strings come and go, held still all is still, and slow strokes give the hand no
// energy.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/contact/tick_work.h"
#include "tests/core/contact/string_scenes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// A crowd of strings of both models, a tool of many spheres, and in half of the scenes a body.
RenderingScene random_scene(SplitMix64& random, int count) {
  std::vector<StringParameters> strings;
  double z = 0.0;
  for (int k = 0; k < count; ++k) {
    StringParameters string = string_at(random.uniform(-1e-3, 1e-3), z);
    string.tension = random.uniform(5.0, 100.0);
    string.youngs_modulus = random.chance(0.3) ? 0.0 : 2e11;
    if (random.chance(0.15)) string.model = StringContact::kStraight;
    if (random.chance(0.5)) string.friction_coefficient = random.uniform(0.1, 1.0);
    strings.push_back(string);
    z += random.uniform(2e-3, 9e-3);
  }
  std::vector<Sphere> tool;
  const auto spheres = 6 + random.below(30);
  for (std::uint64_t i = 0; i < spheres; ++i) {
    const double x = random.uniform(-0.01, 0.01);
    const double y = random.uniform(-1e-3, 1e-3);
    tool.push_back({{x, y, random.uniform(-0.5, 0.5) * z}, random.uniform(3e-3, 9e-3)});
  }
  RenderingScene scene = scene_of(strings, tool);
  scene.instrument.friction = random.chance(0.4);
  scene.instrument.lateral_force = random.chance(0.3);
  if (random.chance(0.3)) {
    scene.parts = {{random.uniform(500.0, 5000.0), random.chance(0.5) ? 0.5 : 0.0}, {}};
    for (std::uint64_t i = 0; i < spheres; ++i) {
      scene.part_of_sphere.push_back(static_cast<std::uint8_t>(i % 2));
    }
  }
  if (random.chance(0.5)) {
    scene.add_body({{{0.55, random.uniform(-0.02, -0.01), random.uniform(0.0, z)}, 8e-3}},
                   pose_at({0, 0, 0}));
  }
  return scene;
}

double middle_of(const RenderingScene& scene) {
  return 0.5 * (scene.capsules_W.front().p_A.z() + scene.capsules_W.back().p_A.z());
}

/// `count` strings alike, and a tool with a large sphere over each.
RenderingScene even_scene(int count) {
  std::vector<StringParameters> strings;
  std::vector<Sphere> tool;
  for (int k = 0; k < count; ++k) {
    const double z = 0.06 * (k - 0.5 * (count - 1));
    strings.push_back(string_at(0.0, z));
    tool.push_back({{0.0, 0.0, z}, 0.04});
  }
  return scene_of(strings, tool);
}

/// Where the tool of even_scene() meets all strings.
double meeting(const RenderingScene& scene) { return 0.04 + scene.capsules_W[0].r; }

/// Length of a change of pose or wrench in the metric of the coupling, N^1/2 m^1/2.
double way_length(const CouplingStiffness& stiffness, const Vector3& dp, const Vector3& dtheta) {
  return std::sqrt(stiffness.kt * dp.squaredNorm() + stiffness.kr() * dtheta.squaredNorm());
}
double wrench_length(const CouplingStiffness& stiffness, const Wrench& a, const Wrench& b) {
  return std::sqrt((a.f - b.f).squaredNorm() / stiffness.kt +
                   (a.t - b.t).squaredNorm() / stiffness.kr());
}

}  // namespace

TEST_CASE("a tool thrown about among many strings and bodies enters nothing, and none enters it") {
  const std::int64_t count = std::max<std::int64_t>(scaled(200), 8);
  long double deepest = 1.0L;
  std::size_t most = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    SplitMix64 random(static_cast<std::uint64_t>(i));
    const RenderingScene scene = random_scene(random, 12 + static_cast<int>(random.below(20)));
    const double z = middle_of(scene);
    ToolRun run(scene, pose_at({0.5, 0.03, z}));
    const double fast = random.uniform(5.0, 60.0);
    const double turn = random.uniform(0.0, 0.3);
    const double along = random.uniform(0.0, 0.02);
    const double depth = random.uniform(0.01, 0.03);
    for (int tick = 0; tick < 100; ++tick) {
      const double t = fast * 1e-3 * tick;
      const double y = 0.03 - depth - depth * std::cos(t + 3.14159);
      const Pose X_WH = pose_at({0.5 + along * std::sin(2.3 * t), y, z + along * std::sin(1.7 * t)},
                                {turn * std::sin(1.1 * t), 0.3 * turn * std::sin(t), 0.0});
      deepest = std::min(deepest, run.tick_along(X_WH));
      most = std::max(most, run.state.touched.size());
    }
  }
  MESSAGE("deepest " << 1e6 * static_cast<double>(deepest) << " um, " << most << " strings held");
  CHECK(deepest >= -1e-6L);
  CHECK(most > 12);
}

TEST_CASE("many strings come and go under a rocking tool without a jump of the wrench") {
  // The strings' energy is convex as long as none slips, so that no change of the wrench is longer
  // than that of the hand's pose, each in the coupling's metric.
  for (const int strings : {9, 10, 21, 40}) {
    const RenderingScene scene = even_scene(strings);
    ToolRun run(scene, pose_at({0.4, 0.08, 0.0}));
    run.stiffness.length = 1.0;
    const double half = 0.03 * strings;
    StringTick before;
    Pose X_before = run.state.X_WG;
    double worst = 0.0;
    std::size_t fewest = 100;
    std::size_t most = 0;
    for (int tick = 0; tick < 1500; ++tick) {
      const double t = 1e-3 * tick;
      const double tilt = 6e-3 / half * std::sin(9.0 * t);
      const double y = meeting(scene) + 1e-3 - 5e-3 * std::min(t, 1.0);
      const Pose X_WH = pose_at({0.4, y, 0.0}, {tilt, 0.0, 0.0});
      run.tick(X_WH);
      const StringTick now = rendered(run);
      const ToolMotion moved_by = motion_between(X_before, X_WH);
      const double way = way_length(run.stiffness, moved_by.dp, moved_by.dtheta);
      const double change = wrench_length(run.stiffness, now.F_H_W, before.F_H_W);
      if (tick > 0) worst = std::max(worst, (change - 1e-5) / way);
      if (tick > 600) fewest = std::min(fewest, now.strings.size());
      most = std::max(most, now.strings.size());
      before = now;
      X_before = X_WH;
    }
    CAPTURE(strings);
    MESSAGE(strings << " strings, " << fewest << " to " << most
                    << " touched: the wrench changes by " << worst
                    << " of what the hand does at most");
    CHECK(worst <= 1.05);
    CHECK(most == static_cast<std::size_t>(strings));
    CHECK(fewest < most);
  }
}

TEST_CASE("many strings held still stay still, and a slow press and its return give no energy") {
  for (const int strings : {9, 21, 64}) {
    const RenderingScene scene = even_scene(strings);
    ToolRun run(scene, pose_at({0.4, 0.08, 0.0}));
    const double top = meeting(scene) + 0.5e-3;
    const double depth = 8e-3;
    double work = 0.0;
    double stored = 0.0;
    StringTick before;
    for (int tick = 1; tick <= 400; ++tick) {
      const double s = tick <= 200 ? tick / 200.0 : 2.0 - tick / 200.0;
      const Pose X_WH = pose_at({0.4, top - depth * s, 0.0}, {0.0, 0.0, 0.0});
      run.tick(X_WH);
      const StringTick now = rendered(run);
      const double down = (tick <= 200 ? -1.0 : 1.0) * depth / 200.0;
      work += 0.5 * (now.F_H_W.f.y() + before.F_H_W.f.y()) * down;
      if (tick == 200) stored = -work;
      before = now;
      if (tick != 200) continue;
      run.hold(X_WH, 100);
      const Wrench held = rendered(run).F_H_W;
      double drift = 0.0;
      for (int still = 0; still < 2000; ++still) {
        run.tick(X_WH);
        drift = std::max(drift, (rendered(run).F_H_W.f - held.f).norm());
      }
      CHECK(drift <= 1e-6);
    }
    CAPTURE(strings);
    MESSAGE(strings << " strings: " << 1e6 * work << " uJ of " << 1e6 * stored << " given back");
    CHECK(stored > 5e-3);
    CHECK(std::abs(work) <= 1e-3 * stored);
    CHECK(run.state.touched.empty());
  }
}

TEST_CASE("strings beyond the capacity stay rigid and are counted, and none is entered") {
  const RenderingScene scene = even_scene(kMaxDeflectingStrings + 3);
  ToolRun run(scene, pose_at({0.5, 0.06, 0.0}));
  long double deepest = 1.0L;
  int refused = 0;
  for (int tick = 0; tick <= 100; ++tick) {
    const double y = meeting(scene) + 1e-3 - 5e-5 * tick;
    deepest = std::min(deepest, run.tick_along(pose_at({0.5, y, 0.0}, {1e-6 * tick, 0, 0})));
    refused = std::max(refused, run.result.strings_refused);
  }
  CHECK(deepest >= -1e-6L);
  CHECK(refused > 0);
  CHECK(run.state.touched.size() == static_cast<std::size_t>(kMaxDeflectingStrings));
}

TEST_CASE("beyond the capacity the force is that of a rigid line, not of one string alone") {
  // All strings at one place: the last ones, which have no room, bear the whole press.
  std::vector<StringParameters> strings(kMaxDeflectingStrings + 6, string_at(0.0, 0.0));
  const RenderingScene scene = scene_of(strings, {{{0.0, 0.0, 0.0}, kTipRadius}});
  ToolRun run(scene, pose_at({0.5, 0.03, 0.0}));
  const double top = kTipRadius + strings.front().radius;
  for (int tick = 0; tick <= 100; ++tick) {
    run.tick(pose_at({0.5, top + 5e-3 * (1.0 - 0.02 * tick), 0.0}));
  }
  const double pressed = 1e3 * 5e-3;
  const StringTick tick = rendered(run);
  CHECK(run.result.strings_refused > 0);
  CHECK(tick.F_H_W.f.norm() >= 0.8 * pressed);
  CHECK(tick.F_H_W.f.norm() <= 1.01 * pressed);
}

TEST_CASE("with a budget a bar across many strings is met in bounded work, and enters none") {
  constexpr std::int64_t kBudget = 364'285;  // half a period of 1 kHz at the nominal price
  for (const int count : {21, 30, 64}) {
    std::vector<StringParameters> strings;
    std::vector<Sphere> bar;
    const double width = 9e-3 * count;
    strings.reserve(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) strings.push_back(string_at(0.0, 9e-3 * k - 0.5 * width));
    // Two rows of spheres close together: every string is met at several.
    for (double z = -0.5 * width; z <= 0.5 * width; z += 3e-3) {
      bar.push_back({{-4e-3, 0.0, z}, 5e-3});
      bar.push_back({{4e-3, 0.0, z}, 5e-3});
    }
    const RenderingScene scene = scene_of(strings, bar);
    ToolRun run(scene, pose_at({0.5, 0.012, 0.0}));
    run.work_budget = kBudget;
    std::int64_t most = 0;
    long double deepest = 1.0L;
    for (int tick = 0; tick <= 200; ++tick) {
      const Pose X_WH = pose_at({0.5, 7e-3 - 6e-5 * tick, 0.0});
      deepest = std::min(deepest, run.tick_along(X_WH));
      most = std::max(most, tick_work(run.result));
    }
    MESSAGE(count << " strings: " << most << " units at most");
    CHECK(deepest >= -1e-6L);
    CHECK(static_cast<double>(most) <= (count <= 30 ? 1.5 : 3.0) * kBudget);
  }
}

}  // namespace hapticd::test
