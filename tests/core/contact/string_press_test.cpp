// One fingertip on one string that yields: force and deflection of the tick against the series law
// of string, kc and kt, solved in long double; the ends of the string, and gliding over them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/contact/clearance.h"
#include "tests/core/contact/string_law_truth.h"
#include "tests/core/contact/string_scenes.h"

namespace hapticd::test {
namespace {

constexpr double kTolerance = 1e-10;

/// A press straight down at lambda, ended at rest.
struct Press {
  RenderingScene scene;
  ToolRun run;
  double displacement;  ///< of the hand below the first touch, m
  double reach;         ///< from the tip's centre to the axis, m

  Press(const StringParameters& string, double lambda, double depth)
      : scene(scene_of({string})), run(scene, pose_at({1.1 * lambda, 0.02, 0.0})) {
    run.options.stop_tolerance = kTolerance;
    const double s = rest_distance(string.radius);
    glide(run, {1.1 * lambda, s + 0.5e-3, 0.0}, {1.1 * lambda, s - depth, 0.0}, 100);
    run.hold(pose_at({1.1 * lambda, s - depth, 0.0}), 40);
    reach = s;
    displacement = depth;
  }
};

StringParameters string_of(double tension, double youngs_modulus, double contact_stiffness) {
  StringParameters string = string_at();
  string.tension = tension;
  string.youngs_modulus = youngs_modulus;
  string.contact_stiffness = contact_stiffness;
  return string;
}

template <typename Visit>
void for_each_press(const Visit& visit) {
  for (const double tension : {0.0, 3.0, 30.0, 300.0}) {
    for (const double youngs_modulus : {0.0, 1.9e11, 1e12}) {
      if (tension + youngs_modulus == 0.0) continue;
      for (const double contact_stiffness : {200.0, 1000.0, 5000.0}) {
        for (const double depth : {0.1e-3, 0.5e-3, 1.5e-3, 4e-3}) {
          CAPTURE(tension);
          CAPTURE(youngs_modulus);
          CAPTURE(contact_stiffness);
          CAPTURE(depth);
          visit(string_of(tension, youngs_modulus, contact_stiffness), depth);
        }
      }
    }
  }
}

/// What the force of a light touch may be off in motion, beside a percent, N.
constexpr double kLightest = 2e-3;
/// Speed of the hand along the string, m/s.
constexpr double kSpeed = 0.2;

/// Presses at `from` on the axis and glides to `to`; the force may change by 1.5 kt v dt per tick.
/// Returns the force at the end, N.
double check_glide(const RenderingScene& scene, const Vector3& from, const Vector3& to,
                   double depth) {
  ToolRun run(scene, pose_at(from + Vector3(0, 0.02, 0)));
  const double s = rest_distance(0.34e-3);
  const Vector3 low(0, s - depth, 0);
  glide(run, from + Vector3(0, s + 1e-3, 0), from + low, 100);
  Vector3 before = rendered(run).F_H_W.f;
  const int ticks = static_cast<int>((to - from).norm() / (kSpeed * 1e-3));
  glide(run, from + low, to + low, ticks, [&](const Vector3& p_WH) {
    const Vector3 now = rendered(run).F_H_W.f;
    CAPTURE(p_WH.x());
    CHECK((now - before).norm() <= 1.5 * run.stiffness.kt * kSpeed * 1e-3);
    before = now;
  });
  return before.norm();
}

/// What a force is settled to, N.
constexpr double kRounding = 1e-11;

}  // namespace

TEST_CASE("pressed at mid-string a fingertip finds the series law of string, kc and kt exactly") {
  for_each_press([](const StringParameters& string, double depth) {
    const Press press(string, 0.5, depth);
    const SpherePress truth =
        press_sphere(law_string(string), 0.5L, press.displacement, press.reach, 1000.0L);
    const Vector3 f = press.run.result.F_H_W.f;
    const auto force = static_cast<double>(truth.force);
    const auto vertex = static_cast<double>(truth.vertex);
    CHECK(std::abs(f.y() - force) <= 1e-9 * force + kRounding);
    // Both legs bear the ball alike, and which of them does is a matter of rounding: one alone
    // leans by its slope, less what it gives way as the vertex goes along.
    const double slope = vertex / 0.55;
    CHECK(std::abs(f.x()) <= press.reach * slope / 0.55 * slope * force + kRounding);
    CHECK(std::abs(f.z()) <= 1e-9 * force + 1e-12);
    CHECK(std::abs(deflection_of(press.run, 0).y() + vertex) <= 1e-7 * vertex + kLeastClearance);
  });
}

TEST_CASE("pressed anywhere on a string a fingertip finds the series law within its own width") {
  // The law takes the finger for a point. A tip of 5 mm rests beside the vertex, where the string
  // yields less: by reach delta / (lambda L)^2 of itself, and sphere_rest knows by how much.
  for (const double lambda : {0.02, 0.05, 0.1, 0.3, 0.77, 0.98}) {
    for_each_press([&](const StringParameters& string, double depth) {
      CAPTURE(lambda);
      const Press press(string, lambda, depth);
      const LawString law = law_string(string);
      const double kc = std::min(string.contact_stiffness, 1000.0);
      // The string's lateral force has drawn the tip along, as far as the coupling yields.
      const double place = press.run.state.X_WG.p.x() / 1.1;
      CHECK((place - lambda) * (0.5 - lambda) >= 0.0);
      const auto delta = static_cast<double>(law_series(law, place, press.displacement, kc));
      const double series = kc * (press.displacement - delta);
      const SpherePress truth = press_sphere(law, place, press.displacement, press.reach, 1000.0L);
      const auto force = static_cast<double>(truth.force);
      const double run = std::min(place, 1.0 - place) * 1.1;
      const double width = press.reach * static_cast<double>(truth.vertex) / (run * run);
      const double f = press.run.result.F_H_W.f.y();
      CHECK(std::abs(f - force) <= (1e-8 + width * width) * force + kRounding);
      CHECK(std::abs(f - series) <= (1e-8 + 2.5 * width) * series);
    });
  }
}

TEST_CASE(
    "a string that yields renders at most kc times the displacement, wherever it is pressed") {
  for (const double x : {-4e-3, -1e-3, -1e-9, -1e-300, 0.0, 1e-300, 1e-12, 1e-6, 1e-4, 1e-3, 3e-3,
                         0.01, 0.3, 1.097, 1.0999, 1.1, 1.1 + 1e-9, 1.101}) {
    for (const double tension : {0.0, 3.0, 300.0}) {
      for (const double contact_stiffness : {50.0, 300.0, 1000.0, 1e6}) {
        for (const double offset : {0.0, 1.5e-3}) {
          const StringParameters string = string_of(tension, 1.9e11, contact_stiffness);
          const RenderingScene scene = scene_of({string});
          ToolRun run(scene, pose_at({x, 0.02, offset}));
          const double s = rest_distance(string.radius);
          CAPTURE(x);
          CAPTURE(tension);
          CAPTURE(contact_stiffness);
          CAPTURE(offset);
          glide(run, {x, s + 1e-3, offset}, {x, s - 4e-3, offset}, 100, [&](const Vector3& p_WH) {
            const Vector3 nearest(std::clamp(x, 0.0, 1.1), 0.0, 0.0);
            const double D = std::max(0.0, s - (p_WH - nearest).norm());
            const Vector3 f = rendered(run).F_H_W.f;
            REQUIRE(f.allFinite());
            // Across the string; along it comes what changes as it is touched elsewhere.
            CHECK(Vector3(0.0, f.y(), f.z()).norm() <=
                  std::min(contact_stiffness, 1000.0) * D * (1.0 + 1e-2) + kLightest);
            CHECK(scene.true_path_gap(run.state, run.state) >= -1e-9L);
          });
        }
      }
    }
  }
}

TEST_CASE("gliding on and off the ends of a string changes the force no faster than kt explains") {
  const Vector3 inside(0.06, 0.0, 0.0);
  const Vector3 outside(-0.02, 0.0, 0.0);
  for (const double tension : {0.0, 3.0, 30.0, 300.0}) {
    for (const double contact_stiffness : {200.0, 1000.0}) {
      for (const double depth : {0.5e-3, 3e-3}) {
        for (const double offset : {0.0, 1e-3}) {
          CAPTURE(tension);
          CAPTURE(contact_stiffness);
          CAPTURE(depth);
          CAPTURE(offset);
          const RenderingScene scene = scene_of({string_of(tension, 1.9e11, contact_stiffness)});
          const Vector3 aside(0.0, 0.0, offset);
          const double left = check_glide(scene, inside + aside, outside + aside, depth);
          CHECK(left == 0.0);
          check_glide(scene, outside + aside, inside + aside, depth);
        }
      }
    }
  }
}

}  // namespace hapticd::test
