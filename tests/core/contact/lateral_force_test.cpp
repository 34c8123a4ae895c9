// The force of a string along its own axis where its halves are unequal: off, a string gives none;
// on, it is the balance of the two halves, and makes the string conservative.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

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
  const double s = rest_distance(run, 0.34e-3);
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

/// Energy the hand gets from pressing at x = 0.5, gliding to 0.1 at a constant depth, lifting, and
/// going back, over all that it moved.
double gain_of_loop(const RenderingScene& scene) {
  ToolRun run(scene, pose_at({0.5, 0.02, 0.0}));
  const double s = rest_distance(run, 0.34e-3);
  const Vector3 way[] = {{0.5, s + 1e-3, 0.0},
                         {0.5, s - 3e-3, 0.0},
                         {0.1, s - 3e-3, 0.0},
                         {0.1, s + 1e-3, 0.0},
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
        const RenderingScene scene = lateral_scene(string, true);
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
        CHECK(std::abs(lateral - truth) <= 1e-9 * contact.force + 2e-9 * std::abs(truth));
        if (lambda < 0.5) CHECK(truth > 0.0);
        if (lambda > 0.5) CHECK(truth < 0.0);
        const double borne = 1000.0 * (run.state.X_WG.p.x() - 1.1 * lambda);
        CHECK(std::abs(tick.F_H_W.f.x() - borne) <= kSettled);
      }
    }
  }
}

TEST_CASE("the lateral force of a rigid string is that of its deflection") {
  for (const double lambda : kLambdas) {
    StringParameters string = string_at();
    string.model = StringContact::kStraight;
    string.k_s = 2.0;
    const RenderingScene scene = lateral_scene(string, true);
    ToolRun run(scene, pose_at({1.1 * lambda, 0.02, 0.0}));
    const StringTick tick = press(run, lambda, 1e-3);
    CAPTURE(lambda);
    const auto truth = static_cast<double>(law_lateral(law_string(string), lambda, 0.5e-3L));
    CHECK(std::abs(tick.F_H_W.f.x() - truth) <= 1e-6 * std::abs(truth) + 1e-12);
  }
}

TEST_CASE("without the lateral force a string gives none but what the tip's width leaves over") {
  for (const double lambda : kLambdas) {
    const StringParameters string = string_at();
    const RenderingScene scene = lateral_scene(string, false);
    ToolRun run(scene, pose_at({1.1 * lambda, 0.02, 0.0}));
    const StringTick tick = press(run, lambda, 3e-3);
    CAPTURE(lambda);
    // The tip rests beside the vertex, where the leg's normal leans by its slope and the vertex
    // that glides along takes all of it but the share the leg yields less there.
    const double leg = std::min(lambda, 1.0 - lambda) * 1.1;
    const double slope = deflection_of(run, 0).norm() / leg;
    const double residual = kTipRadius * slope / leg * slope;
    CHECK(std::abs(tick.F_H_W.f.x()) <= 1.5 * residual * tick.F_H_W.f.norm() + 1e-9);
  }
}

TEST_CASE("gliding along a string without friction is all but free") {
  const RenderingScene scene = lateral_scene(string_at(), false);
  ToolRun run(scene, pose_at({0.2, 0.02, 0.0}));
  const double s = rest_distance(run, 0.34e-3);
  glide(run, {0.2, s + 1e-3, 0.0}, {0.2, s - 3e-3, 0.0}, 100);
  double drag = 0.0;
  glide(run, {0.2, s - 3e-3, 0.0}, {0.9, s - 3e-3, 0.0}, 1400, [&](const Vector3&) {
    drag = std::max(drag, std::abs(run.result.F_H_W.f.x()) / run.result.F_H_W.f.norm());
  });
  MESSAGE("drag at 0.5 m/s: " << 100.0 * drag << " % of the press");
  CHECK(drag < 1e-3);
}

TEST_CASE("with the lateral force a glide along a string gains no energy, without it does") {
  for (const StringContact model : {StringContact::kYielding, StringContact::kStraight}) {
    CAPTURE(static_cast<int>(model));
    StringParameters string = string_at();
    string.model = model;
    const double with = gain_of_loop(lateral_scene(string, true));
    const double without = gain_of_loop(lateral_scene(string, false));
    MESSAGE("energy gained in a loop: " << 100.0 * with << " % with the lateral force, "
                                        << 100.0 * without << " % without");
    CHECK(std::abs(with) < 1e-4);
    CHECK(without > 0.1);
  }
}

}  // namespace hapticd::test
