// More strings under one tool than the dense program has room for: their laws act on the tool
// together, at any number up to the capacity.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/contact/string_balance.h"
#include "tests/core/contact/string_row_truth.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

double log_uniform(SplitMix64& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

/// `count` strings side by side and a tool with a sphere over each.
StringRow even_row(int count, double radius) {
  StringRow row;
  for (int k = 0; k < count; ++k) {
    const double z = 1.5 * radius * (k - 0.5 * (count - 1));
    row.strings.push_back(string_at(0.0, z));
    row.tool.push_back({{0.0, 0.0, z}, radius});
  }
  return row;
}

/// Force of `count` strings alike under one spring kt, the hand pressed `depth` into them:
/// count F(delta) = kt (depth - delta), by bisection.
double shared_force(const StringParameters& string, int count, double kt, double lambda,
                    double depth) {
  using Real = long double;
  const LawString law = law_string(string);
  const auto place = static_cast<Real>(lambda);
  const auto spring = static_cast<Real>(kt);
  const auto pressed = static_cast<Real>(depth);
  Real low = 0.0L;
  Real high = pressed;
  for (int i = 0; i < 200; ++i) {
    const Real delta = (low + high) / 2;
    const Real lift = static_cast<Real>(count) * law_force(law, place, delta);
    (lift > spring * (pressed - delta) ? high : low) = delta;
  }
  return static_cast<double>(spring * (pressed - low));
}

/// Strings and a tool of all kinds, and where the hand goes.
struct RandomPress {
  StringRow row;
  Vector3 p_WH;
  Vector3 phi_WH;
};

StringParameters random_string(SplitMix64& random, double z) {
  StringParameters string = string_at(random.uniform(-0.5e-3, 0.5e-3), z);
  const double length = log_uniform(random, 0.6, 3.0);
  string.p_WA[0] = -random.uniform(0.15, 0.85) * length;
  string.p_WB[0] = string.p_WA[0] + length;
  string.tension = log_uniform(random, 2.0, 300.0);
  string.youngs_modulus = random.chance(0.2) ? 0.0 : log_uniform(random, 1e9, 3e11);
  string.radius = log_uniform(random, 0.1e-3, 1e-3);
  string.contact_stiffness = random.chance(0.3) ? log_uniform(random, 200.0, 1000.0) : 1000.0;
  return string;
}

RandomPress random_press(SplitMix64& random, int count) {
  RandomPress press;
  press.row.stiffness = {log_uniform(random, 30.0, 3e4), random.uniform(0.02, 1.0)};
  const double radius = log_uniform(random, 4e-3, 30e-3);
  double z = 0.0;
  for (int k = 0; k < count; ++k) {
    const double r = radius * random.uniform(0.7, 1.0);
    press.row.strings.push_back(random_string(random, z));
    press.row.tool.push_back({{random.uniform(-5e-3, 5e-3), radius - r, z}, r});
    z += 1.1 * radius + random.uniform(4e-3, 10e-3);
  }
  // Off centre, and a little tilted: no end of the tool by more than a few millimetres.
  const double origin = random.uniform(0.0, z);
  for (Sphere& sphere : press.row.tool) sphere.p.z() -= origin;
  const double tilt = 2e-3 / z;
  press.phi_WH = {random.uniform(-tilt, tilt), random.uniform(-tilt, tilt),
                  random.uniform(-0.05, 0.05)};
  press.p_WH = {random.uniform(-3e-3, 3e-3), radius - log_uniform(random, 0.1e-3, 10e-3), origin};
  return press;
}

/// A press of the hand from above to its place, and a second of rest.
StringTick pressed(const RandomPress& press, ToolRun& run) {
  for (int tick = 0; tick <= 150; ++tick) {
    const double above = 6e-3 * (1.0 - tick / 150.0);
    run.tick(pose_at(press.p_WH + Vector3(0.0, above, 0.0), press.phi_WH));
  }
  run.hold(pose_at(press.p_WH, press.phi_WH), 50);
  return rendered(run);
}

}  // namespace

TEST_CASE("strings alike under one tool share its one spring, however many they are") {
  for (const int count : {1, 7, 8, 9, 12, 16, 21, 40, 64}) {
    for (const double depth : {0.5e-3, 3e-3, 10e-3}) {
      const StringRow row = even_row(count, 0.04);
      const RenderingScene scene = scene_of(row.strings, row.tool);
      ToolRun run(scene, pose_at({0.4, 0.06, 0.0}));
      const double touch = 0.04 + row.strings[0].radius;
      glide(run, {0.4, touch + 1e-3, 0.0}, {0.4, touch - depth, 0.0}, 100);
      run.hold(pose_at({0.4, touch - depth, 0.0}), 30);
      const StringTick tick = rendered(run);
      const double truth = shared_force(row.strings[0], count, run.stiffness.kt, 0.4 / 1.1, depth);
      CAPTURE(count);
      CAPTURE(depth);
      MESSAGE(count << " strings, " << 1e3 * depth << " mm: " << tick.F_H_W.f.y() << " N of "
                    << truth << ", " << 100.0 * (tick.F_H_W.f.y() / truth - 1.0) << " %");
      CHECK(std::abs(tick.F_H_W.f.y() / truth - 1.0) <= 0.005);
      CHECK(tick.strings.size() == static_cast<std::size_t>(count));
      CHECK(run.result.strings_refused == 0);
    }
  }
}

TEST_CASE(
    "a tool tilted, off centre and of any stiffness rests on many strings where they balance it") {
  const std::int64_t count = std::max<std::int64_t>(scaled(1000), 30);
  int judged = 0;
  double worst = 0.0;
  double worst_string = 0.0;
  for (std::int64_t i = 0; i < count; ++i) {
    SplitMix64 random(static_cast<std::uint64_t>(i));
    const int strings = 9 + static_cast<int>(random.below(56));
    const RandomPress press = random_press(random, strings);
    const std::optional<RowRest> truth = rest_on_row(press.row, press.p_WH, press.phi_WH);
    if (!truth || truth->F_H_W.f.norm() < 1e-3) continue;
    const RenderingScene scene = scene_of(press.row.strings, press.row.tool);
    ToolRun run(scene, pose_at(press.p_WH + Vector3(0.0, 7e-3, 0.0), press.phi_WH));
    run.stiffness = press.row.stiffness;
    const StringTick tick = pressed(press, run);
    CAPTURE(i);
    CAPTURE(strings);
    CAPTURE(run.stiffness.kt);
    const double pull = truth->F_H_W.f.norm();
    const double error = (tick.F_H_W.f - truth->F_H_W.f).norm() / pull;
    CHECK(error <= 0.005);
    CHECK(run.result.strings_refused == 0);
    worst = std::max(worst, error);
    for (const PressedString& contact : tick.strings) {
      const double force = truth->force[static_cast<std::size_t>(contact.string)];
      worst_string = std::max(worst_string, std::abs(contact.force - force) / pull);
    }
    ++judged;
  }
  MESSAGE(judged << " of " << count << " presses judged; force off by " << 100.0 * worst
                 << " % at most, one string's by " << 100.0 * worst_string << " % of it");
  CHECK(judged > count / 3);
  CHECK(worst_string <= 0.005);
}

}  // namespace hapticd::test
