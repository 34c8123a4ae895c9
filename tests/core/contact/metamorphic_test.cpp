// What must not change the force: order of spheres and obstacles, mirroring, moving the whole
// scene, units of length. The same input twice gives the same bits.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/math/rotation.h"
#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/pose_composition.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr int kTicks = 400;

struct World {
  std::vector<Sphere> tool;
  std::vector<Capsule> capsules_W;
  std::vector<Sphere> body;
  Pose X_WB;
  std::vector<Pose> X_WH;
};

World make_world() {
  World world;
  world.tool.reserve(40);
  world.body.reserve(60);
  world.X_WH.reserve(kTicks);
  SplitMix64 random(5);
  for (int i = 0; i < 40; ++i) {
    world.tool.push_back(
        {to_vector(random.direction()) * random.uniform(0.0, 0.04), random.uniform(4e-3, 8e-3)});
  }
  world.capsules_W = {{{-0.3, 0, 0.02}, {0.3, 0, 0.02}, 3e-3},
                      {{-0.3, 0.01, -0.03}, {0.3, 0, -0.02}, 0.34e-3}};
  for (int i = 0; i < 60; ++i) world.body.push_back({{0.003 * i, 0, 0}, 6e-3});
  world.X_WB = {exp_rotation({0, 0.4, 0.1}), {-0.05, -0.01, 0.0}};
  for (int i = 0; i < kTicks; ++i) {
    const double t = 1e-3 * i;
    world.X_WH.push_back(pose_at(
        {0.01 * std::sin(9 * t), 0.08 - 0.05 * std::min(1.0, 4 * t), 0.01 * std::sin(7 * t)},
        {0.3 * std::sin(5 * t), 0.5 * t, 0.2 * std::sin(4 * t)}));
  }
  return world;
}

std::vector<Wrench> render(const World& world, const OptimiserOptions& options = {},
                           const CouplingStiffness& stiffness = {}) {
  RenderingScene scene(world.tool);
  scene.capsules_W = world.capsules_W;
  scene.add_body(world.body, world.X_WB);
  ToolRun run(scene, world.X_WH.front());
  run.options = options;
  run.stiffness = stiffness;
  std::vector<Wrench> out;
  out.reserve(world.X_WH.size());
  for (const Pose& X_WH : world.X_WH) out.push_back(run.tick(X_WH).F_H_W);
  return out;
}

double largest_force(const std::vector<Wrench>& wrenches) {
  double largest = 0.0;
  for (const Wrench& F : wrenches) largest = std::max(largest, F.f.norm());
  return largest;
}

template <typename Map>
double largest_difference(const std::vector<Wrench>& a, const std::vector<Wrench>& b, Map map) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Wrench mapped = map(a[i]);
    largest = std::max({largest, (mapped.f - b[i].f).norm(), (mapped.t - b[i].t).norm()});
  }
  return largest;
}

}  // namespace

TEST_CASE("the order of tool spheres, strings and body spheres does not change the force") {
  const World world = make_world();
  World permuted = world;
  std::reverse(permuted.tool.begin(), permuted.tool.end());
  std::reverse(permuted.capsules_W.begin(), permuted.capsules_W.end());
  std::rotate(permuted.body.begin(), permuted.body.begin() + 17, permuted.body.end());
  const auto a = render(world);
  CHECK(largest_force(a) > 2.0);
  CHECK(largest_difference(a, render(permuted), [](const Wrench& F) { return F; }) < 1e-9);
}

TEST_CASE("a scene mirrored left to right gives the mirrored force and torque") {
  const World world = make_world();
  World mirrored = world;
  const auto mirror = [](Vector3& p) { p.z() = -p.z(); };
  const auto mirror_rotation = [](Quaternion& q) { q = {q.w(), -q.x(), -q.y(), q.z()}; };
  for (Sphere& sphere : mirrored.tool) mirror(sphere.p);
  for (Sphere& sphere : mirrored.body) mirror(sphere.p);
  for (Capsule& capsule : mirrored.capsules_W) {
    mirror(capsule.p_A);
    mirror(capsule.p_B);
  }
  mirror(mirrored.X_WB.p);
  mirror_rotation(mirrored.X_WB.q);
  for (Pose& X : mirrored.X_WH) {
    mirror(X.p);
    mirror_rotation(X.q);
  }
  CHECK(largest_difference(render(world), render(mirrored), [](const Wrench& F) {
          return Wrench{{F.f.x(), F.f.y(), -F.f.z()}, {-F.t.x(), -F.t.y(), F.t.z()}};
        }) < 1e-9);
}

TEST_CASE("a scene moved by a kilometre and turned gives the turned force") {
  const World world = make_world();
  World moved_world = world;
  const Pose X_MW{exp_rotation({0.3, -0.8, 1.1}), {800, -500, 330}};
  for (Capsule& capsule : moved_world.capsules_W) {
    capsule.p_A = transform(X_MW, capsule.p_A);
    capsule.p_B = transform(X_MW, capsule.p_B);
  }
  moved_world.X_WB = compose(X_MW, world.X_WB);
  for (Pose& X : moved_world.X_WH) X = compose(X_MW, X);
  CHECK(largest_difference(render(world), render(moved_world), [&](const Wrench& F) {
          return Wrench{X_MW.q * F.f, X_MW.q * F.t};
        }) < 1e-6);
}

TEST_CASE("millimetres instead of metres give the same force") {
  const World world = make_world();
  World in_mm = world;
  static constexpr double kUnit = 1000.0;
  for (Sphere& sphere : in_mm.tool) sphere = {sphere.p * kUnit, sphere.r * kUnit};
  for (Sphere& sphere : in_mm.body) sphere = {sphere.p * kUnit, sphere.r * kUnit};
  for (Capsule& capsule : in_mm.capsules_W)
    capsule = {capsule.p_A * kUnit, capsule.p_B * kUnit, capsule.r * kUnit};
  in_mm.X_WB.p *= kUnit;
  for (Pose& X : in_mm.X_WH) X.p *= kUnit;
  OptimiserOptions options;
  options.margin *= kUnit;
  options.skin *= kUnit;
  options.stop_tolerance *= kUnit;
  CouplingStiffness stiffness;
  stiffness.kt /= kUnit;
  stiffness.length *= kUnit;
  CHECK(largest_difference(render(world), render(in_mm, options, stiffness), [](const Wrench& F) {
          return Wrench{F.f, F.t * kUnit};
        }) < 1e-6);
}

TEST_CASE("the same input gives the same bits") {
  const World world = make_world();
  const auto a = render(world);
  const auto b = render(world);
  bool same = true;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      same = same &&
             std::bit_cast<std::uint64_t>(a[i].f[k]) == std::bit_cast<std::uint64_t>(b[i].f[k]) &&
             std::bit_cast<std::uint64_t>(a[i].t[k]) == std::bit_cast<std::uint64_t>(b[i].t[k]);
    }
  }
  CHECK(same);
}

}  // namespace hapticd::test
