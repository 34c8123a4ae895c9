// The portable loops and the AVX2 loops: equal bits, equal order, equal work, in every kind of
// scene.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>

#include "core/math/cpu.h"
#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"
#include "tests/support/skip.h"

namespace hapticd::test {
namespace {

/// Forbids AVX2 while it lives.
class WithoutAvx2 {
 public:
  WithoutAvx2() { allow_avx2(false); }
  ~WithoutAvx2() { allow_avx2(true); }
  WithoutAvx2(const WithoutAvx2&) = delete;
  WithoutAvx2& operator=(const WithoutAvx2&) = delete;
  WithoutAvx2(WithoutAvx2&&) = delete;
  WithoutAvx2& operator=(WithoutAvx2&&) = delete;
};

/// Contacts of `scene` both ways; false when any bit, the order or the work differs.
bool agree(const CheckedScene& scene, const Pose& X_WG, const QueryOptions& options) {
  const auto fast = found_contacts(scene, X_WG, options);
  std::unique_ptr<ContactSet> plain;
  {
    const WithoutAvx2 guard;
    plain = found_contacts(scene, X_WG, options);
  }
  const auto bits = [](double number) { return std::bit_cast<std::uint64_t>(number); };
  bool same = fast->contacts.size() == plain->contacts.size() && fast->tests == plain->tests &&
              bits(fast->minimum_gap) == bits(plain->minimum_gap) &&
              bits(fast->covered_margin) == bits(plain->covered_margin);
  for (std::size_t i = 0; same && i < fast->contacts.size(); ++i)
    same = same_bits(fast->contacts[i], plain->contacts[i]);
  return same;
}

bool skipped() {
  if (avx2_available()) return false;
  skip("this processor has no AVX2");
  return true;
}

QueryOptions random_options(SplitMix64& random) {
  QueryOptions options;
  options.margin = std::pow(10.0, random.uniform(-6.0, 0.0));
  if (random.chance(0.3)) options.horizon = options.margin * random.uniform(1.0, 100.0);
  if (random.chance(0.3)) options.tool_level = 1 + static_cast<int>(random.below(3));
  if (random.chance(0.3)) options.body_level = 1 + static_cast<int>(random.below(3));
  return options;
}

}  // namespace

TEST_CASE("near scenes have the same bits, order and work with and without AVX2") {
  if (skipped()) return;
  SplitMix64 random(1);
  for (std::int64_t trial = 0; trial < scaled(2'000); ++trial) {
    const SceneParts parts = random_parts(random);
    REQUIRE(agree(CheckedScene(parts), parts.X_WG, random_options(random)));
  }
}

TEST_CASE("far scenes and any unit have the same bits, order and work with and without AVX2") {
  if (skipped()) return;
  SplitMix64 random(2);
  for (std::int64_t trial = 0; trial < scaled(2'000); ++trial) {
    SceneParts parts = random_parts(random);
    const double unit = std::pow(10.0, random.uniform(-100.0, 100.0));
    for (Sphere& sphere : parts.tool_G) sphere = {sphere.p * unit, sphere.r * unit};
    for (Capsule& c : parts.capsules_W) c = {c.p_A * unit, c.p_B * unit, c.r * unit};
    for (SceneParts::Body& body : parts.bodies) {
      for (Sphere& sphere : body.spheres_B) sphere = {sphere.p * unit, sphere.r * unit};
      body.X_WB.p *= unit;
    }
    const double far = unit * std::pow(10.0, random.uniform(-1.0, 9.0));
    parts.X_WG.p = far * to_vector(random.direction());
    QueryOptions options = random_options(random);
    options.margin *= unit;
    options.horizon *= unit;
    REQUIRE(agree(CheckedScene(parts), parts.X_WG, options));
  }
}

TEST_CASE("degenerate scenes have the same bits with and without AVX2") {
  if (skipped()) return;
  SplitMix64 random(3);
  CheckedScene scene;
  std::vector<Sphere> heap(40, Sphere{{0, 0, 0}, 0.0});
  heap.push_back({{1, 0, 0}, 0.5});
  scene.set_tool(heap);
  scene.capsules = {{{0, 0, 0}, {0, 0, 0}, 0.0},
                    {{-1, 0, 0}, {1, 0, 0}, 0.0},
                    {{0, -1e7, 0}, {0, 1e7, 0}, 1},
                    {{0, 0, 0}, {1e-160, 0, 0}, 0.1},
                    {{0, 0, 0}, {1e-140, 0, 0}, 0.1}};
  scene.add_body(heap, {});
  scene.add_body({{{0, 0, 0}, 1e6}}, {{1, 0, 0, 0}, {0, -1e6, 0}});
  for (const Pose& X_WG : {Pose{}, Pose{{0, 1, 0, 0}, {0, 0, 0}}, Pose{{1, 0, 0, 0}, {-0.0, -1, 0}},
                           Pose{random_rotation(random), random_vector(random, 1e-15)}}) {
    for (const double margin : {1e-300, 1e-3, 1.0, 1e9}) REQUIRE(agree(scene, X_WG, {margin}));
  }
}

}  // namespace hapticd::test
