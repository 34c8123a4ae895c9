// Strings that do not yield, as the paper renders them: straight in the contact problem, and the
// force of each by Eq. 10-13 at delta = D / k_s of its own contact force, no more than kc D. Truth:
// the law in long double and the geometry of the contact.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/contact/clearance.h"
#include "tests/core/contact/string_law_truth.h"
#include "tests/core/contact/string_scenes.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kKt = 1000.0;

StringParameters rigid_string(double y = 0.0, double z = 0.0) {
  StringParameters string = string_at(y, z);
  string.model = StringContact::kStraight;
  return string;
}

/// min(F(D / k_s), min(kc, kt) D), N.
double law(const StringParameters& string, double lambda, double displacement) {
  const LawString of = law_string(string);
  const long double D = displacement;
  const long double kc = std::min(of.contact_stiffness, static_cast<long double>(kKt));
  const long double delta = D / static_cast<long double>(string.k_s);
  return static_cast<double>(std::min(law_force(of, lambda, delta), kc * D));
}

/// Presses the tool's origin from well above to `p_WH` and stays.
StringTick press(ToolRun& run, const Vector3& p_WH) {
  run.options.stop_tolerance = 1e-11;
  glide(run, p_WH + Vector3(0, 0.01, 0), p_WH, 100);
  run.hold(pose_at(p_WH), 20);
  return rendered(run);
}

}  // namespace

TEST_CASE("a rigid string gives the law's force at D / k_s along its contact, and at most kc D") {
  for (const double lambda : {0.01, 0.1, 0.5, 0.9}) {
    for (const double k_s : {0.109, 0.5, 1.0, 3.0}) {
      for (const double contact_stiffness : {150.0, 1000.0, 1e5}) {
        for (const double depth : {0.2e-3, 1e-3, 4e-3}) {
          for (const double offset : {0.0, 1e-3, -2.5e-3}) {
            StringParameters string = rigid_string();
            string.k_s = k_s;
            string.contact_stiffness = contact_stiffness;
            const RenderingScene scene = scene_of({string});
            ToolRun run(scene, pose_at({1.1 * lambda, 0.03, offset}));
            const double s = rest_distance(string.radius);
            const Vector3 p_WH(1.1 * lambda, s - depth, offset);
            const StringTick tick = press(run, p_WH);
            const Vector3 from_axis(0.0, p_WH.y(), p_WH.z());
            const double D = s - from_axis.norm();
            CAPTURE(lambda);
            CAPTURE(k_s);
            CAPTURE(contact_stiffness);
            CAPTURE(depth);
            CAPTURE(offset);
            if (D <= 0.0) {
              CHECK(tick.F_H_W.f.norm() == 0.0);
              continue;
            }
            REQUIRE(tick.strings.size() == 1);
            const double force = law(string, lambda, D);
            const Vector3 truth = force * from_axis.normalized();
            CHECK((tick.F_H_W.f - truth).norm() <= 1e-6 * force + 1e-9);
            CHECK((tick.strings[0].F_W - truth).norm() <= 1e-6 * force + 1e-9);
            CHECK(tick.strings[0].deflection == within(D / k_s, 1e-6));
            CHECK(tick.strings[0].displacement == within(D, 1e-6));
          }
        }
      }
    }
  }
}

TEST_CASE("the torque of a rigid string shrinks with its force") {
  const Vector3 lever(0.03, 0.0, 0.02);
  const RenderingScene scene = scene_of({rigid_string()}, {{lever, kTipRadius}});
  ToolRun run(scene, pose_at({0.3, 0.03, 0.0}));
  const StringTick tick = press(run, Vector3(0.3, 0.002, 0.0) - lever);
  REQUIRE(tick.strings.size() == 1);
  const Wrench& all = run.result.F_H_W;
  const double share = tick.F_H_W.f.norm() / all.f.norm();
  CHECK(share < 0.5);
  CHECK((tick.F_H_W.t - share * all.t).norm() <= 1e-9 * all.t.norm());
  const Vector3 arm = tick.strings[0].p_WC - run.state.X_WG.p;
  CHECK((tick.F_H_W.t - arm.cross(tick.F_H_W.f)).norm() <= 1e-9 * all.t.norm());
}

TEST_CASE("two rigid strings pressed at once give each the law of its own contact force") {
  for (const double ratio : {1.0, 3.0, 10.0}) {
    for (const double shift : {0.0, 0.4e-3, -0.7e-3}) {
      StringParameters left = rigid_string(0.0, -3.5e-3);
      StringParameters right = rigid_string(0.5e-3, 3.5e-3);
      right.tension = ratio * left.tension;
      const RenderingScene scene = scene_of({left, right});
      ToolRun run(scene, pose_at({0.55, 0.03, 0.0}));
      const Vector3 p_WH(0.55, 1.5e-3, shift);
      const StringTick tick = press(run, p_WH);
      CAPTURE(ratio);
      CAPTURE(shift);
      REQUIRE(tick.strings.size() == 2);

      // The tip rests on both axes, at the crossing of two circles above them, and the two contact
      // forces together stretch the coupling.
      const double s = rest_distance(left.radius);
      const Vector3 a(0.0, 0.0, -3.5e-3);
      const Vector3 b(0.0, 0.5e-3, 3.5e-3);
      const double half = 0.5 * (b - a).norm();
      const Vector3 up = Vector3(1, 0, 0).cross(a - b).normalized();
      const Vector3 centre = 0.5 * (a + b) + std::sqrt(s * s - half * half) * up;
      const Vector3 n_a = (centre - a).normalized();
      const Vector3 n_b = (centre - b).normalized();
      const Vector3 pull = kKt * (centre - Vector3(0.0, p_WH.y(), p_WH.z()));
      const double det = n_a.y() * n_b.z() - n_a.z() * n_b.y();
      const double F_a = (pull.y() * n_b.z() - pull.z() * n_b.y()) / det;
      const double F_b = (n_a.y() * pull.z() - n_a.z() * pull.y()) / det;
      REQUIRE(F_a > 0.0);
      REQUIRE(F_b > 0.0);
      CHECK(tick.strings[0].force == within(law(left, 0.5, F_a / kKt), 1e-5));
      CHECK(tick.strings[1].force == within(law(right, 0.5, F_b / kKt), 1e-5));
      const Vector3 sum = tick.strings[0].force * n_a + tick.strings[1].force * n_b;
      CHECK((tick.F_H_W.f - sum).norm() <= 1e-5 * sum.norm());
    }
  }
}

TEST_CASE("a body beside a rigid string keeps the full stiffness of the coupling") {
  RenderingScene scene = scene_of({rigid_string(0.0, 0.0)});
  scene.add_body({{{0.0, 0.0, 0.0}, 5e-3}}, pose_at({0.55, -4.66e-3, 7e-3}));
  ToolRun run(scene, pose_at({0.55, 0.03, 3e-3}));
  const StringTick tick = press(run, {0.55, 1e-3, 3e-3});
  REQUIRE(tick.strings.size() == 1);
  // What is not the string's is the body's, unchanged from the contact problem.
  const Vector3 of_body =
      run.result.F_H_W.f - kKt * tick.strings[0].displacement * tick.strings[0].nhat_W;
  CHECK(of_body.norm() > 0.1);
  CHECK((tick.F_H_W.f - (tick.strings[0].F_W + of_body)).norm() <= 1e-9);
  CHECK((run.result.F_H_W.f - kKt * (run.state.X_WG.p - Vector3(0.55, 1e-3, 3e-3))).norm() <=
        2.0 * kKt * kLeastClearance);
}

TEST_CASE(
    "with k_s frozen from the device half as much tension again is felt, recomputed it is not") {
  constexpr double kDevice = 300.0;
  const auto force = [](double tension, double k_s) {
    StringParameters string = rigid_string();
    string.tension = tension;
    string.youngs_modulus = 0.0;
    string.k_s = k_s;
    const RenderingScene scene = scene_of({string});
    ToolRun run(scene, pose_at({0.275, 0.03, 0.0}));
    return press(run, {0.275, rest_distance(string.radius) - 2e-3, 0.0}).F_H_W.f.norm();
  };
  const double frozen = k_s_from_device(1.1, 30.0, 0.25, kDevice);
  const double reference = force(30.0, frozen);
  CHECK(reference == within(kDevice * 2e-3, 1e-2));
  CHECK(force(45.0, frozen) == within(1.5 * reference, 1e-6));
  const double recomputed = k_s_from_device(1.1, 45.0, 0.25, kDevice);
  CHECK(force(45.0, recomputed) == within(reference, 1e-2));
}

}  // namespace hapticd::test
