// The force of a string along its own axis where its halves are unequal: that of one that yields is
// the balance of the two halves, which makes the string conservative; one that does not yield has
// it where that is asked for.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/contact/clearance.h"
#include "tests/core/contact/string_law_truth.h"
#include "tests/core/contact/string_scenes.h"

namespace hapticd::test {
namespace {

/// The tool may rest this much of the coupling's force off its balance: kt times the default stop
/// tolerance, N.
constexpr double kSettled = 2e-3;

constexpr double kLambdas[] = {0.02, 0.1, 0.3, 0.5, 0.8, 0.97};

/// Presses at lambda and stays; the tool may glide along the string until all is in balance.
StringTick press(ToolRun& run, double lambda, double depth) {
  run.options.stop_tolerance = 1e-12;
  const double s = rest_distance(0.34e-3);
  const double x = 1.1 * lambda;
  glide(run, {x, s + 1e-3, 0.0}, {x, s - depth, 0.0}, 200);
  const Pose X_WH = pose_at({x, s - depth, 0.0});
  run.hold(X_WH, 200);
  return rendered(run);
}

RenderingScene lateral_scene(const StringParameters& string, bool on) {
  RenderingScene scene = scene_of({string});
  scene.instrument.lateral_force = on;
  return scene;
}

/// Energy the hand gets from pressing at x = 0.5, gliding to `x_end` at a constant depth, lifting,
/// and going back, over all that it moved.
double gain_of_loop(const RenderingScene& scene, double x_end = 0.1) {
  ToolRun run(scene, pose_at({0.5, 0.02, 0.0}));
  const double s = rest_distance(0.34e-3);
  const Vector3 way[] = {{0.5, s + 1e-3, 0.0},
                         {0.5, s - 3e-3, 0.0},
                         {x_end, s - 3e-3, 0.0},
                         {x_end, s + 1e-3, 0.0},
                         {0.5, s + 1e-3, 0.0}};
  double gained = 0.0;
  double moved = 0.0;
  Vector3 f_before = Vector3::Zero();
  Vector3 p_before = way[0];
  for (int k = 0; k < 4; ++k) {
    glide(run, way[k], way[k + 1], 2000, [&](const Vector3& p_WH) {
      const Vector3 f = rendered(run).F_H_W.f;
      const double work = 0.5 * (f + f_before).dot(p_WH - p_before);
      gained += work;
      moved += std::abs(work);
      f_before = f;
      p_before = p_WH;
    });
  }
  return gained / moved;
}

}  // namespace

TEST_CASE("the lateral force is the balance of the two halves of the deflected string") {
  for (const double lambda : kLambdas) {
    for (const double tension : {3.0, 30.0, 200.0}) {
      for (const double depth : {0.5e-3, 3e-3, 5e-3}) {
        StringParameters string = string_at();
        string.tension = tension;
        const RenderingScene scene = lateral_scene(string, false);
        ToolRun run(scene, pose_at({1.1 * lambda, 0.02, 0.0}));
        const StringTick tick = press(run, lambda, depth);
        CAPTURE(lambda);
        CAPTURE(tension);
        CAPTURE(depth);
        REQUIRE(tick.strings.size() == 1);
        REQUIRE(run.state.touched.size() == 1);
        const StringBend& bend = run.state.touched[0].bend;
        const auto truth =
            static_cast<double>(law_lateral(law_string(string), bend.lambda, bend.u_W.norm()));
        // What the tool gets beyond its contact force is the lateral force, and the coupling bears
        // both.
        const PressedString& contact = tick.strings[0];
        const double lateral = (contact.F_W - contact.force * contact.nhat_W).x();
        // The vertex stands off the tool by the least clearance, and the force goes by its square.
        const double off = 4.0 * kLeastClearance / bend.u_W.norm();
        CHECK(std::abs(lateral - truth) <= 1e-9 * contact.force + (2e-9 + off) * std::abs(truth));
        if (lambda < 0.5) CHECK(truth > 0.0);
        if (lambda > 0.5) CHECK(truth < 0.0);
        const double borne = 1000.0 * (run.state.X_WG.p.x() - 1.1 * lambda);
        CHECK(std::abs(tick.F_H_W.f.x() - borne) <= kSettled);
      }
    }
  }
}

// What it stores is the integral of F(D / k_s) over D: k_s times the energy of its deflection.
TEST_CASE("the lateral force of a rigid string is k_s times that of its deflection") {
  for (const double lambda : kLambdas) {
    StringParameters string = string_at();
    string.model = StringContact::kStraight;
    string.k_s = 2.0;
    const RenderingScene scene = lateral_scene(string, true);
    ToolRun run(scene, pose_at({1.1 * lambda, 0.02, 0.0}));
    const StringTick tick = press(run, lambda, 1e-3);
    CAPTURE(lambda);
    const auto truth = static_cast<double>(2.0L * law_lateral(law_string(string), lambda, 0.5e-3L));
    CHECK(std::abs(tick.F_H_W.f.x() - truth) <= 1e-6 * std::abs(truth) + 1e-12);
  }
}

TEST_CASE("a rigid string without the lateral force gives none") {
  for (const double lambda : kLambdas) {
    StringParameters string = string_at();
    string.model = StringContact::kStraight;
    const RenderingScene scene = lateral_scene(string, false);
    ToolRun run(scene, pose_at({1.1 * lambda, 0.02, 0.0}));
    const StringTick tick = press(run, lambda, 1e-3);
    CAPTURE(lambda);
    CHECK(std::abs(tick.F_H_W.f.x()) <= 1e-9);
  }
}

TEST_CASE("gliding along a string without friction costs its lateral force and no more") {
  const StringParameters string = string_at();
  const RenderingScene scene = lateral_scene(string, false);
  ToolRun run(scene, pose_at({0.2, 0.02, 0.0}));
  const double s = rest_distance(0.34e-3);
  glide(run, {0.2, s + 1e-3, 0.0}, {0.2, s - 3e-3, 0.0}, 100);
  double drag = 0.0;
  glide(run, {0.2, s - 3e-3, 0.0}, {0.9, s - 3e-3, 0.0}, 1400, [&](const Vector3&) {
    const StringBend& bend = run.state.touched[0].bend;
    const auto truth =
        static_cast<double>(law_lateral(law_string(string), bend.lambda, bend.u_W.norm()));
    const Vector3& f = run.result.F_H_W.f;
    drag = std::max(drag, std::abs(f.x() - truth) / f.norm());
  });
  MESSAGE("drag at 0.5 m/s: " << 100.0 * drag << " % of the press");
  CHECK(drag < 1e-3);
}

// A ball looks the same however it is turned.
TEST_CASE("what a string does to a ball has no moment about the ball's centre") {
  const Vector3 p_GS(0.03, -0.02, 0.01);
  for (const StringContact model : {StringContact::kYielding, StringContact::kStraight}) {
    for (const double lambda : kLambdas) {
      CAPTURE(static_cast<int>(model));
      CAPTURE(lambda);
      StringParameters string = string_at();
      string.model = model;
      RenderingScene scene = scene_of({string}, {{p_GS, kTipRadius}});
      scene.instrument.lateral_force = true;
      const Vector3 above = Vector3(1.1 * lambda, 0.02, 0.0) - p_GS;
      ToolRun run(scene, pose_at(above));
      glide(run, above, above - Vector3(0.0, 0.017, 0.0), 200);
      run.hold(pose_at(above - Vector3(0.0, 0.017, 0.0)), 200);
      const StringTick tick = rendered(run);
      REQUIRE(tick.F_H_W.f.norm() > 0.05);
      const Vector3 p_GS_W = run.state.X_WG.q * p_GS;
      const Vector3 moment = tick.F_H_W.t - p_GS_W.cross(tick.F_H_W.f);
      CHECK(moment.norm() <= 1e-9 * tick.F_H_W.f.norm());
    }
  }
}

TEST_CASE("a glide along a string that yields gains no energy, nor along a rigid one with it") {
  const double yielding = gain_of_loop(lateral_scene(string_at(), false));
  StringParameters string = string_at();
  string.model = StringContact::kStraight;
  for (const double k_s : {1.0, 0.5, 3.0}) {
    string.k_s = k_s;
    CAPTURE(k_s);
    const double with = gain_of_loop(lateral_scene(string, true));
    const double without = gain_of_loop(lateral_scene(string, false));
    MESSAGE("energy gained in a loop: " << 100.0 * yielding << " % where it yields, rigid "
                                        << 100.0 * with << " % with the lateral force, "
                                        << 100.0 * without << " % without");
    CHECK(std::abs(with) < 1e-4);
    CHECK(without > 0.1);
  }
  CHECK(std::abs(yielding) < 1e-4);
}

// At 0.01 L the string is stiffer than kc to begin with, at 0.03 L it is not.
TEST_CASE("a glide along a rigid string gains none where kc bounds it either") {
  StringParameters string = string_at();
  string.model = StringContact::kStraight;
  string.contact_stiffness = 300.0;
  const RenderingScene scene = lateral_scene(string, true);
  const double gained = gain_of_loop(scene, 0.005);
  MESSAGE("energy gained in a loop: " << 100.0 * gained << " %");
  CHECK(std::abs(gained) < 1e-4);
}

}  // namespace hapticd::test
