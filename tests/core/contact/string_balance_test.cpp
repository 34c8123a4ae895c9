// Several strings at once, and strings beside a body: the configuration a tick converges to is in
// equilibrium, every string by its own force; order, mirror and place of the scene do not matter.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/contact/clearance.h"
#include "core/math/rotation.h"
#include "tests/core/contact/string_balance.h"
#include "tests/support/pose_composition.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

double log_uniform(SplitMix64& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

/// A press of a few spheres on one to three strings, and on a body in half of the cases.
struct RandomPress {
  BalanceScene judged;
  Vector3 p_from, p_to;
  double turn;  ///< about x, at the end, rad
};

std::vector<StringParameters> random_strings(SplitMix64& random) {
  std::vector<StringParameters> strings;
  const auto count = 1 + random.below(3);
  for (std::uint64_t k = 0; k < count; ++k) {
    StringParameters string =
        string_at(random.uniform(-1e-3, 1e-3), 9e-3 * static_cast<double>(k) - 9e-3);
    string.tension = log_uniform(random, 5.0, 200.0);
    string.youngs_modulus = random.chance(0.2) ? 0.0 : log_uniform(random, 1e9, 1e12);
    string.contact_stiffness = random.chance(0.3) ? log_uniform(random, 200.0, 1000.0) : 1000.0;
    strings.push_back(string);
  }
  return strings;
}

std::vector<Sphere> random_tool(SplitMix64& random) {
  std::vector<Sphere> tool;
  const auto count = 1 + random.below(5);
  for (std::uint64_t i = 0; i < count; ++i) {
    const double y = random.uniform(-1.0, 1.0);
    const double z = random.uniform(-1.0, 1.0);
    tool.push_back({{0.0, 5e-3 * y, 12e-3 * z}, random.uniform(3e-3, 7e-3)});
  }
  return tool;
}

/// Forces of a session of strokes over three strings with a finger of seven spheres.
struct World {
  std::vector<StringParameters> strings;
  std::vector<Sphere> tool;
  std::vector<Pose> X_WH;
};

World make_world() {
  World world;
  for (int k = 0; k < 3; ++k) {
    StringParameters string = string_at(0.4e-3 * k, 0.012 * k - 0.012);
    string.tension = 20.0 + 15.0 * k;
    world.strings.push_back(string);
  }
  for (int i = 0; i < 7; ++i) {
    world.tool.push_back({{1e-3 * i, 0.6e-3 * i, 6e-3 * i - 0.018}, 5e-3 - 0.2e-3 * i});
  }
  for (int tick = 0; tick < 400; ++tick) {
    const double t = 1e-3 * tick;
    world.X_WH.push_back(pose_at({0.4 + 0.02 * std::sin(9 * t),
                                  0.012 - 0.016 * std::min(1.0, 4 * t), 0.001 * std::sin(7 * t)},
                                 {0.1 * std::sin(5 * t), 0.2 * t, 0.05 * std::sin(4 * t)}));
  }
  return world;
}

std::vector<StringTick> play(const World& world) {
  const RenderingScene scene = scene_of(world.strings, world.tool);
  ToolRun run(scene, world.X_WH.front());
  std::vector<StringTick> out;
  for (const Pose& X_WH : world.X_WH) {
    run.tick(X_WH);
    out.push_back(rendered(run));
  }
  return out;
}

template <typename Map>
double largest_difference(const std::vector<StringTick>& a, const std::vector<StringTick>& b,
                          const Map& map) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Wrench mapped = map(a[i].F_H_W);
    largest =
        std::max({largest, (mapped.f - b[i].F_H_W.f).norm(), (mapped.t - b[i].F_H_W.t).norm()});
  }
  return largest;
}

}  // namespace

TEST_CASE("a fingertip wedged between two strings sinks to where both laws together hold it") {
  for (const double half_spacing : {1.5e-3, 3e-3, 4.5e-3}) {
    for (const double contact_stiffness : {300.0, 1000.0}) {
      for (const double part : {0.1, 0.3, 0.5}) {
        CAPTURE(half_spacing);
        CAPTURE(contact_stiffness);
        CAPTURE(part);
        StringParameters left = string_at(0.0, -half_spacing);
        left.contact_stiffness = contact_stiffness;
        StringParameters right = left;
        right.p_WA[2] = right.p_WB[2] = half_spacing;
        const RenderingScene scene = scene_of({left, right});
        ToolRun run(scene, pose_at({0.55, 0.02, 0.0}));
        run.options.stop_tolerance = 1e-10;
        const double s = rest_distance(left.radius);
        const double first = std::sqrt(s * s - half_spacing * half_spacing);
        const Vector3 p_WH(0.55, (1.0 - part) * first, 0.0);
        glide(run, {0.55, first + 0.5e-3, 0.0}, p_WH, 100);
        run.hold(pose_at(p_WH), 20);

        // Centre, vertex and rest place of each string lie on one line, so the height of the
        // centre tells all: bisection in long double.
        const LawString law = law_string(left);
        const auto w = static_cast<long double>(half_spacing);
        const auto gap = static_cast<long double>(scene.true_path_gap(run.state, run.state));
        const long double reach = kTipRadius + left.radius + gap;
        long double low = 0.0L;
        long double high = std::sqrt(reach * reach - w * w);
        long double force = 0.0L;
        for (int i = 0; i < 200; ++i) {
          const long double y = (low + high) / 2;
          const long double distance = std::hypot(w, y);
          long double vertex = reach - distance;
          for (int k = 0; k < 5; ++k) {
            vertex = sphere_rest(law, 0.5L, vertex, reach).height - distance;
          }
          force = vertex_spring(law, 0.5L, vertex, 1000.0L).force /
                  sphere_rest(law, 0.5L, vertex, reach).share;
          const long double lift = 2 * force * y / distance;
          (lift > 1000.0L * (y - static_cast<long double>(p_WH.y())) ? low : high) = y;
        }
        const double y = static_cast<double>((low + high) / 2);
        CHECK(std::abs(run.state.X_WG.p.y() - y) < 1e-8);
        const StringTick tick = rendered(run);
        REQUIRE(tick.strings.size() == 2);
        for (const PressedString& contact : tick.strings) {
          CHECK(contact.force == within(static_cast<double>(force), 1e-5));
        }
        CHECK(tick.F_H_W.f.y() == within(1000.0 * (y - p_WH.y()), 1e-5));
      }
    }
  }
}

TEST_CASE("strings, bodies and the hand balance in every press, each string by its own force") {
  const std::int64_t count = std::max<std::int64_t>(scaled(2000), 40);
  double worst = 0.0;
  int settled = 0;
  int several = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    SplitMix64 random(static_cast<std::uint64_t>(i));
    const std::vector<StringParameters> strings = random_strings(random);
    RenderingScene scene = scene_of(strings, random_tool(random));
    BalanceScene judged{scene, strings};
    if (random.chance(0.5)) {
      judged.body_W = {{{0.55, random.uniform(-0.02, -0.008), random.uniform(-0.01, 0.01)}, 8e-3}};
      scene.add_body(judged.body_W, pose_at({0, 0, 0}));
    }
    const double z = random.uniform(-2e-3, 2e-3);
    ToolRun run(scene, pose_at({0.55, 0.04, z}));
    run.options.stop_tolerance = 1e-9;
    const double depth = random.uniform(0.005, 0.02);
    glide(run, {0.55, 0.03, z}, {0.55, 0.015 - depth, z}, 200);
    const Pose X_WH = pose_at({0.55, 0.015 - depth, z}, {random.uniform(-0.1, 0.1), 0.0, 0.0});
    run.hold(X_WH, 60);
    if (run.result.status == ContactStatus::kFree) continue;
    const Balance balance = balance_of(judged, run, X_WH);
    const StringTick tick = rendered(run);
    CAPTURE(i);
    CHECK(balance.residual <= 1e-3);
    worst = std::max(worst, balance.residual);
    ++settled;
    several += tick.strings.size() > 1 ? 1 : 0;
    // What the tick reports of each string is what its law says at its own deflection.
    for (const PressedString& contact : tick.strings) {
      const double pull = balance.string_pull[static_cast<std::size_t>(contact.string)];
      CHECK(contact.force == within(pull, 2e-3));
      // The string stands off the tool by what is left of the clearance, which is not felt.
      CHECK(std::abs(contact.deflection - deflection_of(run, contact.string).norm()) <=
            10.0 * run.state.clearance);
    }
  }
  MESSAGE(settled << " presses, " << several << " on several strings; unbalanced at most "
                  << 100.0 * worst << " % of the hand's pull");
  CHECK(settled > count / 2);
  CHECK(several > count / 10);
}

TEST_CASE("the order of strings and of tool spheres does not change the force") {
  const World world = make_world();
  World permuted = world;
  std::reverse(permuted.strings.begin(), permuted.strings.end());
  std::rotate(permuted.tool.begin(), permuted.tool.begin() + 3, permuted.tool.end());
  const auto a = play(world);
  double largest = 0.0;
  for (const StringTick& tick : a) largest = std::max(largest, tick.F_H_W.f.norm());
  CHECK(largest > 0.5);
  CHECK(largest_difference(a, play(permuted), [](const Wrench& F) { return F; }) < 1e-9);
}

TEST_CASE("strings mirrored left to right give the mirrored force and torque") {
  const World world = make_world();
  World mirrored = world;
  for (StringParameters& string : mirrored.strings) {
    string.p_WA[2] = -string.p_WA[2];
    string.p_WB[2] = -string.p_WB[2];
  }
  for (Sphere& sphere : mirrored.tool) sphere.p.z() = -sphere.p.z();
  for (Pose& X : mirrored.X_WH) {
    X.p.z() = -X.p.z();
    X.q = {X.q.w(), -X.q.x(), -X.q.y(), X.q.z()};
  }
  CHECK(largest_difference(play(world), play(mirrored), [](const Wrench& F) {
          return Wrench{{F.f.x(), F.f.y(), -F.f.z()}, {-F.t.x(), -F.t.y(), F.t.z()}};
        }) < 1e-9);
}

TEST_CASE("strings turned end to end give the same force") {
  const World world = make_world();
  World turned = world;
  for (StringParameters& string : turned.strings) std::swap(string.p_WA, string.p_WB);
  CHECK(largest_difference(play(world), play(turned), [](const Wrench& F) { return F; }) < 1e-9);
}

TEST_CASE("strings and tool moved by a kilometre and turned give the turned force") {
  const World world = make_world();
  World moved_world = world;
  const Pose X_MW{exp_rotation({0.3, -0.8, 1.1}), {800, -500, 330}};
  for (StringParameters& string : moved_world.strings) {
    string.p_WA = to_array(transform(X_MW, to_vector(string.p_WA)));
    string.p_WB = to_array(transform(X_MW, to_vector(string.p_WB)));
  }
  for (Pose& X : moved_world.X_WH) X = compose(X_MW, X);
  CHECK(largest_difference(play(world), play(moved_world), [&](const Wrench& F) {
          return Wrench{X_MW.q * F.f, X_MW.q * F.t};
        }) < 1e-6);
}

}  // namespace hapticd::test
