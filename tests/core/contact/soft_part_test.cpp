// Soft parts of a tool. Truth: the series of springs in closed form or by bisection in long double,
// the implicit Euler recursion of spring and damper, its limit in continuous time, and the work of
// the hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/contact/clearance.h"
#include "core/math/rotation.h"
#include "tests/core/contact/strokes.h"
#include "tests/support/part_displacement.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kTip = 5e-3;
/// Allowed depth of the committed path, m.
constexpr long double kAllowedDepth = 1e-6L;

/// A ball on a floor at height 0 that is flat for all its size allows.
RenderingScene floor_scene(std::vector<Sphere> tool) {
  RenderingScene scene(std::move(tool));
  scene.add_body({{{0, -1000, 0}, 1000}}, pose_at({0, 0, 0}));
  return scene;
}

/// Height of the tip's centre at which it touches the floor.
double touch_height() { return kTip; }

StringParameters string_parameters(const Capsule& capsule) {
  StringParameters string;
  string.p_WA = to_array(capsule.p_A);
  string.p_WB = to_array(capsule.p_B);
  string.radius = capsule.r;
  return string;
}

}  // namespace

TEST_CASE("a soft part pressed on what is rigid feels the series of coupling and fingertip") {
  for (const double k : {1.0, 30.0, 1e3, 1e5, 1e9}) {
    for (const double kt : {1e-3, 1.0, 1e3, 1e6, 1e9}) {
      CAPTURE(k);
      CAPTURE(kt);
      RenderingScene scene = floor_scene({{{0, 0, 0}, kTip}});
      scene.parts = {{k, 0.0}};
      ToolRun run(scene, pose_at({0, 0.01, 0}));
      run.stiffness.kt = kt;
      const double D = 3e-3;
      run.hold(pose_at({0, touch_height() - D, 0}), 20);
      const double truth = D / (1.0 / kt + 1.0 / k);
      CHECK(run.result.F_H_W.f.y() == within(truth, 1e-9));
      const double v = part_displacement(run.state, 0).y();
      CHECK(std::abs(v - truth / k) <= 1e-9 * truth / k + kLeastClearance);
      CHECK(std::abs(run.state.X_WG.p.y() - (touch_height() - truth / k)) <= 2.0 * kLeastClearance);
    }
  }
}

TEST_CASE("a soft part on a string that yields is one more spring in the series") {
  const Capsule capsule{{-0.55, 0, 0}, {0.55, 0, 0}, kStringRadius};
  for (const double kc : {300.0, 1e3, 5e3}) {
    for (const double k : {50.0, 800.0, 1e5}) {
      for (const double D : {0.5e-3, 3e-3, 15e-3}) {
        CAPTURE(kc);
        CAPTURE(k);
        CAPTURE(D);
        RenderingScene scene({{{0, 0, 0}, kTip}});
        scene.capsules_W = {capsule};
        StringParameters string = string_parameters(capsule);
        string.contact_stiffness = kc;
        scene.strings = {derive_string(string)};
        scene.parts = {{k, 0.0}};
        const double height = touch_height() + capsule.r;
        ToolRun run(scene, pose_at({0, 0.02, 0}));
        run.hold(pose_at({0, height - D, 0}), 20);
        // f(delta) = F with D = delta + F (1/kc' + 1/k); by bisection, mid-string. The tip is
        // round: in their angle the two legs leave a little between it and the vertex, which is
        // height times (secant - 1), and so the finger moves less than the vertex and feels more.
        const long double half = 0.55L;
        const long double EA = static_cast<long double>(string.youngs_modulus) *
                               3.14159265358979323846L * capsule.r * capsule.r;
        const long double coupling = 1.0L / static_cast<long double>(run.stiffness.kt);
        const long double contact = 1.0L / std::min(kc, run.stiffness.kt) - coupling;
        const auto force = [&](long double d) {
          const long double leg = std::sqrt(half * half + d * d);
          const long double ext = 2.0L * d * d / (leg + half);
          return (string.tension + EA * ext / (2.0L * half)) * 2.0L * d / leg;
        };
        const auto vertex = [&](long double d) { return d + contact * force(d); };
        const auto secant = [&](long double d) { return std::hypot(1.0L, vertex(d) / half); };
        const auto felt = [&](long double d) {
          return force(d) / (1.0L - height * vertex(d) / (half * half * secant(d)));
        };
        const auto pressed = [&](long double d) {
          return vertex(d) - height * (secant(d) - 1.0L) + felt(d) * (coupling + 1.0L / k);
        };
        long double low = 0.0L;
        long double high = 2.0L * D;
        for (int i = 0; i < 200; ++i) {
          const long double middle = (low + high) / 2;
          (pressed(middle) < D ? low : high) = middle;
        }
        const auto truth = static_cast<double>(felt(low));
        CHECK(run.result.F_H_W.f.y() == within(truth, 1e-5));
        CHECK(part_displacement(run.state, 0).y() == within(truth / k, 1e-5));
        REQUIRE(run.state.touched.size() == 1);
        CHECK(run.state.touched[0].bend.u_W.norm() ==
              within(static_cast<double>(vertex(low)), 1e-5));
      }
    }
  }
}

TEST_CASE("parts of different softness pressed at once each yield by their own spring") {
  const std::vector<double> k{200.0, 1e3, 5e3, 0.0, 4e4, 700.0};
  std::vector<Sphere> fingers;
  fingers.reserve(k.size() + 1);
  for (std::size_t i = 0; i < k.size(); ++i) {
    fingers.push_back({{0.02 * static_cast<double>(i) - 0.05, 0, 0}, kTip});
  }
  // A rigid part would hold the rest off; it is too short to touch.
  fingers[3].p.y() = 0.02;
  RenderingScene scene = floor_scene(fingers);
  for (std::size_t i = 0; i < k.size(); ++i) {
    scene.parts.push_back({k[i], 0.0});
    scene.part_of_sphere.push_back(static_cast<std::uint8_t>(i));
  }
  ToolRun run(scene, pose_at({0, 0.01, 0}));
  const double D = 4e-3;
  run.hold(pose_at({0, touch_height() - D, 0}), 10);
  // Equilibrium of height y and tilt phi about z over springs at x_i: two linear equations, without
  // those that would have to pull.
  const double kt = run.stiffness.kt;
  const long double h = -D;
  std::vector<double> pressed = k;
  long double y = 0.0L;
  long double phi = 0.0L;
  const auto sunk = [&](std::size_t i) {
    return pressed[i] > 0.0 ? static_cast<double>(-(y + phi * fingers[i].p.x())) : 0.0;
  };
  for (bool pulls = true; pulls;) {
    long double a = kt;
    long double b = 0.0L;
    long double c = run.stiffness.kr();
    for (std::size_t i = 0; i < k.size(); ++i) {
      const double x = fingers[i].p.x();
      a += pressed[i];
      b += pressed[i] * x;
      c += pressed[i] * x * x;
    }
    y = (kt * h * c) / (a * c - b * b);
    phi = -b * y / c;
    pulls = false;
    for (std::size_t i = 0; i < k.size(); ++i) {
      if (sunk(i) >= 0.0) continue;
      pressed[i] = 0.0;
      pulls = true;
    }
  }
  for (std::size_t i = 0; i < k.size(); ++i) {
    CAPTURE(i);
    // The floor is flat and the tilt small: second order 1e-4 of the displacement.
    CHECK(part_displacement(run.state, static_cast<std::int32_t>(i)).y() == within(sunk(i), 2e-3));
  }
  CHECK(run.result.F_H_W.f.y() == within(static_cast<double>(kt * (y - h)), 1e-3));
}

TEST_CASE("a sixth soft part touched at once is rigid for the tick and counted") {
  std::vector<Sphere> fingers;
  fingers.reserve(7);
  for (int i = 0; i < 7; ++i) fingers.push_back({{0.01 * i - 0.03, 0, 0}, kTip});
  RenderingScene scene = floor_scene(fingers);
  for (std::uint8_t i = 0; i < 7; ++i) {
    scene.parts.push_back({500.0, 0.0});
    scene.part_of_sphere.push_back(i);
  }
  ToolRun run(scene, pose_at({0, 0.01, 0}));
  const Pose X_WH = pose_at({0, touch_height() - 2e-3, 0});
  long double gap = 1.0L;
  for (int i = 0; i < 10; ++i) gap = std::min(gap, run.tick_along(X_WH));
  CHECK(run.result.parts_refused > 0);
  CHECK(run.state.parts.size() == static_cast<std::size_t>(kMaxSoftParts));
  CHECK(gap >= -kAllowedDepth);
  // Between seven springs side by side and none.
  CHECK(run.result.F_H_W.f.y() > 2e-3 / (1.0 / run.stiffness.kt + 1.0 / 3500.0));
  CHECK(run.result.F_H_W.f.y() < run.stiffness.kt * 2e-3);
}

TEST_CASE("a damped part answers a step by the implicit Euler recursion of spring and damper") {
  for (const double k : {100.0, 2e3, 1e6}) {
    for (const double c : {0.1, 5.0, 1e3, 1e6}) {
      for (const double dt : {1e-4, 1e-3, 5e-3}) {
        CAPTURE(k);
        CAPTURE(c);
        CAPTURE(dt);
        RenderingScene scene = floor_scene({{{0, 0, 0}, kTip}});
        scene.parts = {{k, c}};
        ToolRun run(scene, pose_at({0, touch_height() + 1e-6, 0}));
        run.options.stop_tolerance = 1e-9;
        run.options.skin = 0.0;
        const double D = 2e-3;
        const double kt = run.stiffness.kt;
        long double v = 0.0L;
        for (int tick = 0; tick < 60; ++tick) {
          // kt (D - v') = k v' + c (v' - v) / dt
          v = (kt * static_cast<long double>(D) + c * v / dt) / (kt + k + c / dt);
          run.tick(pose_at({0, touch_height() - D, 0}), dt);
          REQUIRE(std::abs(part_displacement(run.state, 0).y() - static_cast<double>(v)) < 1.5e-9);
          REQUIRE(std::abs(run.result.F_H_W.f.y() - static_cast<double>(kt * (D - v))) < 1.5e-6);
        }
      }
    }
  }
}

TEST_CASE("as ticks grow short a damped part follows spring and damper in continuous time") {
  const double k = 500.0;
  const double c = 10.0;
  const double D = 2e-3;
  const double t_end = 8e-3;
  double error_before = 0.0;
  for (const int ticks : {8, 16, 32, 64, 128}) {
    RenderingScene scene = floor_scene({{{0, 0, 0}, kTip}});
    scene.parts = {{k, c}};
    ToolRun run(scene, pose_at({0, touch_height() + 1e-6, 0}));
    const double kt = run.stiffness.kt;
    const double dt = t_end / ticks;
    for (int i = 0; i < ticks; ++i) {
      run.tick(pose_at({0, touch_height() - D, 0}), dt);
    }
    const double v = kt * D / (kt + k) * (1.0 - std::exp(-(kt + k) / c * t_end));
    const double error = std::abs(part_displacement(run.state, 0).y() - v);
    CAPTURE(ticks);
    if (ticks > 8) CHECK(error < 0.6 * error_before);
    error_before = error;
  }
  CHECK(error_before < 2e-2 * D);
}

TEST_CASE(
    "after a touch a soft part goes back to rest: at once by its spring, in time by its damper") {
  for (const double c : {0.0, 5.0}) {
    RenderingScene scene = floor_scene({{{0, 0, 0}, kTip}});
    const double k = 500.0;
    scene.parts = {{k, c}};
    ToolRun run(scene, pose_at({0, 0.01, 0}));
    run.hold(pose_at({0, touch_height() - 3e-3, 0}), 200);
    long double v = part_displacement(run.state, 0).y();
    CHECK(v > 1e-3L);
    for (int tick = 0; tick < 200; ++tick) {
      CHECK(run.tick_along(pose_at({0, 0.05, 0})) >= 0.0L);
      v *= c / 1e-3 / (k + c / 1e-3);
      if (v < 2e-9L) break;
      CHECK(part_displacement(run.state, 0).y() == within(static_cast<double>(v), 1e-9));
    }
    CHECK(run.hold(pose_at({0, 0.05, 0}), 10).F_H_W.f.norm() == 0.0);
    CHECK(run.state.parts.empty());
    CHECK(part_displacement(run.state, 0).norm() == 0.0);
  }
}

TEST_CASE("a tick of no time moves a part without a damper alone") {
  for (const double c : {0.0, 5.0}) {
    RenderingScene scene = floor_scene({{{0, 0, 0}, kTip}});
    scene.parts = {{500.0, c}};
    ToolRun run(scene, pose_at({0, 0.01, 0}));
    run.options.skin = 0.0;
    run.hold(pose_at({0, touch_height() - 1e-3, 0}), 5);
    const double before = part_displacement(run.state, 0).y();
    for (int i = 0; i < 5; ++i) {
      run.tick(pose_at({0, touch_height() - 3e-3, 0}), 0.0);
    }
    const double after = part_displacement(run.state, 0).y();
    if (c > 0.0) {
      CHECK(after == before);
      CHECK(run.result.F_H_W.f.y() == within(1e3 * (3e-3 - before), 1e-9));
    } else {
      CHECK(after == within(3e-3 * 1000.0 / 1500.0, 1e-6));
    }
  }
}

TEST_CASE("whatever the hand does, it never gets more work out of soft parts than it put in") {
  // Work with the force at the end of each motion: for a stored energy that is convex in the hand's
  // place (a flat floor, no rotation) it is never less than what is stored, however the ticks are.
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SplitMix64 random(seed);
    RenderingScene scene = floor_scene({{{0, 0, 0}, kTip}, {{0.0, 2e-3, 0}, kTip}});
    scene.parts = {{random.uniform(50.0, 2e3), seed == 1 ? 0.0 : random.uniform(0.1, 10.0)},
                   {random.uniform(50.0, 2e3), random.uniform(0.0, 10.0)}};
    scene.part_of_sphere = {0, 1};
    ToolRun run(scene, pose_at({0, 0.01, 0}));
    run.stiffness.length = 1.0;
    Vector3 p_WH(0, 0.01, 0);
    Vector3 rate(0, 0, 0);
    double work = 0.0;
    double least = 0.0;
    // The first thousands only come down to the floor.
    const std::int64_t ticks = scaled(1'000'000) + 10'000;
    for (std::int64_t i = 0; i < ticks; ++i) {
      // Noise through two low passes, pulled to the floor: touches and leaves it all the time.
      rate += 0.02 * (to_vector(random.direction()) * 0.3 - rate);
      Vector3 next = p_WH + 1e-3 * rate;
      next += 2e-3 * (Vector3(0, touch_height() - 1e-3, 0) - next);
      const Vector3 motion = next - p_WH;
      p_WH = next;
      const double dt = random.chance(0.1) ? random.uniform(0.0, 5e-3) : 1e-3;
      run.tick(pose_at(p_WH), dt);
      work -= run.result.F_H_W.f.dot(motion);
      double stored = 0.5 * run.stiffness.kt * (p_WH - run.state.X_WG.p).squaredNorm();
      for (const SoftPart& soft : run.state.parts) {
        const auto part = static_cast<std::size_t>(soft.part);
        stored += 0.5 * scene.parts[part].stiffness * soft.v_G.squaredNorm();
      }
      // A tool that stands off the floor stretches the coupling by what the hand does not feel.
      const double off = run.state.clearance / kClearanceDecay;
      const double lent = (run.result.F_H_W.f.norm() + run.stiffness.kt * off) * off;
      least = std::min(least, work - stored + lent);
    }
    CHECK(work > 0.0);
    // Forces are those of a configuration up to the stop tolerance away.
    CHECK(least >= -1e-9);
    MESSAGE("put in " << work << " J, at least " << least << " J more than was stored");
  }
}

TEST_CASE("rigid parts change nothing: the same bits as a tool without parts") {
  for (std::int64_t i = 0; i < scaled(2'000); ++i) {
    const Stroke plain = make_string_stroke(static_cast<std::uint64_t>(i));
    Stroke parted = make_string_stroke(static_cast<std::uint64_t>(i));
    parted.scene.parts = {{0.0, 0.0}, {0.0, 3.0}};
    for (std::size_t k = 0; k < parted.scene.tool_spheres.size(); ++k) {
      parted.scene.part_of_sphere.push_back(static_cast<std::uint8_t>(k % 2));
    }
    ToolRun a(plain.scene, plain.X_WH.front());
    ToolRun b(parted.scene, parted.X_WH.front());
    for (const Pose& X_WH : plain.X_WH) {
      a.tick(X_WH);
      b.tick(X_WH);
      REQUIRE(a.state.X_WG.p == b.state.X_WG.p);
      REQUIRE(a.result.F_H_W.f == b.result.F_H_W.f);
      REQUIRE(a.result.F_H_W.t == b.result.F_H_W.t);
    }
  }
}

TEST_CASE("a fingertip out of range is refused with the name of its field") {
  CHECK(!check_part({}).has_value());
  CHECK(!check_part({1.0, 0.0}).has_value());
  CHECK(!check_part({1e9, 1e6}).has_value());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double stiffness : {-1.0, 1e-300, 0.999, 1.001e9, nan, infinity, -infinity}) {
    const auto fault = check_part({stiffness, 0.0});
    REQUIRE(fault.has_value());
    CHECK(std::strcmp(fault->field, "fingertip.stiffness_n_per_m") == 0);
    CHECK(std::strcmp(fault->range, "[1, 1e9]") == 0);
  }
  for (const double damping : {-1e-9, 1.001e6, nan, infinity}) {
    const auto fault = check_part({100.0, damping});
    REQUIRE(fault.has_value());
    CHECK(std::strcmp(fault->field, "fingertip.damping_n_s_per_m") == 0);
    CHECK(std::strcmp(fault->range, "[0, 1e6]") == 0);
  }
}

}  // namespace hapticd::test
