// The parts of a study: gestures that a seed draws, settings, errors and histograms, and a press
// whose force is known in closed form.
#include <doctest/doctest.h>

#include <cmath>
#include <stdexcept>

#include "core/contact/tick_work.h"
#include "core/scene/quality.h"
#include "core/scene/scene.h"
#include "tests/core/scene/scene_builder.h"
#include "tests/oracle/study_report.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kFinger = 5e-3;
constexpr double kBall = 0.05;

/// A finger over a ball about the origin.
SceneDescription finger_and_ball() {
  SceneDescription scene = finger_scene({0.0, 0.07, 0.0});
  BodyDescription ball;
  ball.name = "ball";
  ball.shape = shape_of({{{0.0, 0.0, 0.0}, kBall}});
  scene.bodies.push_back(ball);
  scene.quality_level = kDefaultQuality;
  return scene;
}

StudyGesture draw(const Scene& scene, std::uint64_t seed, double speed = 0.05) {
  PathJudge judge(scene.tool_scene(0));
  return choose_study_gesture(scene, 0, judge, seed, speed);
}

bool same(const Pose& a, const Pose& b) { return a.p == b.p && a.q.coeffs() == b.q.coeffs(); }

StudyTick pushed(double newton) {
  StudyTick tick;
  tick.felt_W = Vector3(newton, 0.0, 0.0);
  return tick;
}

}  // namespace

TEST_CASE("a seed draws the same gesture again, another seed or speed another one") {
  const Scene scene(finger_and_ball());
  const StudyGesture one = draw(scene, 1);
  for (const double t : {0.0, 0.1, 0.37}) CHECK(same(one.at(t), draw(scene, 1).at(t)));
  CHECK_FALSE(same(one.at(0.1), draw(scene, 2).at(0.1)));
  CHECK_FALSE(same(one.at(0.1), draw(scene, 1, 0.5).at(0.1)));
}

TEST_CASE("a gesture begins and ends in the air, and presses as deep as it says in between") {
  const Scene scene(finger_and_ball());
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    CAPTURE(seed);
    const StudyGesture gesture = draw(scene, seed);
    CHECK(gesture.at(0.0).p.norm() > kBall + kFinger + 1e-3);
    // It lifts off along the normal of the place where it came down, and has slid by centimetres.
    CHECK(gesture.at(kStudyGesture_s).p.norm() > kBall + kFinger + 1e-3);
    CHECK(gesture.X_WH_touch.p.norm() == within(kBall + kFinger, 1e-3));
    CHECK(gesture.depth >= 0.5e-3);
    CHECK(gesture.depth <= 6e-3);
  }
}

TEST_CASE("a press on a ball has the force of the spring to the nearest place outside it") {
  const Scene scene(finger_and_ball());
  StudyGesture gesture;
  gesture.X_WH_touch.p = Vector3(0.0, kBall + kFinger, 0.0);
  gesture.depth = 3e-3;
  StudySetting setting = parse_setting("usual:", scene.description());
  PathRun judge(scene);
  const std::vector<StudyTick> ticks = play_study(scene, 0, setting, gesture, &judge);
  REQUIRE(ticks.size() == 400);
  const double kt = scene.description().tools[0].coupling.kt;
  CHECK(ticks[200].felt_W.y() == within(kt * gesture.depth, 1e-6));
  CHECK(ticks[200].path_gap_m >= 0.0);
  CHECK(ticks[200].path_gap_m <= 2e-9);
  CHECK(ticks[0].felt_W.norm() == 0.0);
  CHECK(tick_work(ticks[200].counts) > 0);
}

TEST_CASE("the judged way of every level is the simulation's own, and enters nothing") {
  const Scene scene(finger_and_ball());
  PathRun judge(scene);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const StudyGesture gesture = draw(scene, seed, 0.5);
    for (int level = 0; level < kQualityLevels; ++level) {
      const StudySetting setting =
          parse_setting("l:level=" + std::to_string(level), scene.description());
      for (const StudyTick& tick : play_study(scene, 0, setting, gesture, &judge)) {
        REQUIRE(tick.path_gap_m >= 0.0);
      }
    }
  }
}

TEST_CASE("a penalty enters the ball by what the gesture presses it, and the paper does not") {
  const Scene scene(finger_and_ball());
  StudyGesture gesture;
  gesture.X_WH_touch.p = Vector3(0.0, kBall + kFinger, 0.0);
  gesture.depth = 3e-3;
  PathRun judge(scene);
  const auto penalty = play_baseline(scene, 0, BaselineMethod::kPenalty, gesture, judge.judge());
  const auto paper = play_baseline(scene, 0, BaselineMethod::kPaper, gesture, judge.judge());
  CHECK(penalty[200].path_gap_m == within(-gesture.depth, 1e-6));
  CHECK(paper[200].path_gap_m > -1e-6);
}

TEST_CASE("errors are sums over the truth's ticks, a slower run holding its last force") {
  const std::vector<StudyTick> run{pushed(1.0), pushed(3.0)};
  const std::vector<StudyTick> truth{pushed(1.0), pushed(2.0), pushed(3.0), pushed(3.5)};
  const StudyErrors errors = compare(run, truth, 2.0);
  CHECK(errors.ticks == 4);
  CHECK(errors.felt_square == doctest::Approx(1.0 + 0.25));
  CHECK(errors.truth_square == doctest::Approx(1.0 + 4.0 + 9.0 + 12.25));
  CHECK(errors.felt_max == doctest::Approx(1.0));
  CHECK(compare(truth, truth, 1.0).felt_square == 0.0);
}

TEST_CASE("quantiles of a histogram are those of its values to a twentieth") {
  Histogram histogram;
  for (int i = 1; i <= 1000; ++i) count_value(i, histogram);
  for (const double q : {0.01, 0.5, 0.99}) {
    CHECK(quantile(histogram, q) == within(1000.0 * q, 0.05));
  }
  CHECK(quantile({}, 0.5) == 0.0);
}

TEST_CASE("a setting changes what it names and nothing else, a level first") {
  const SceneDescription scene = finger_and_ball();
  const StudySetting few = parse_setting("few:sub_steps=2,level=4,rate=500", scene);
  CHECK(few.name == "few");
  CHECK(few.rate_hz == 500.0);
  CHECK(few.options.sub_steps == 2);
  CHECK(few.options.stop_tolerance == quality_of(4).options.stop_tolerance);
  CHECK(few.options.skin == scene.contact.skin);
  CHECK_FALSE(few.changes_strings());
  const StudySetting wide = parse_setting("wide:margin=2mm,rate=1kHz", scene);
  CHECK(wide.options.margin == 0.002);
  CHECK(wide.rate_hz == 1000.0);
  CHECK(parse_setting("m:modes=8", scene).changes_strings());
  const StudySetting rare = parse_setting("r:wave_substeps=16", scene);
  CHECK(rare.changes_strings());
  CHECK(with_strings(scene, rare).instrument.substeps == 16);
  CHECK(scene_of_setting("coarse:level=1,scene=guqin_coarse") == "guqin_coarse");
  CHECK(scene_of_setting("usual").empty());
}

TEST_CASE("a setting that makes no sense is refused with what would") {
  const SceneDescription scene = finger_and_ball();
  for (const char* bad :
       {"", ":sub_steps=2", "a:substeps=2", "a:sub_steps=0", "a:sub_steps=x", "a:sub_steps",
        "a:margin=1kg", "a:margin=2km", "a:string=soft", "a:level=5"}) {
    CAPTURE(bad);
    CHECK_THROWS_AS((void)parse_setting(bad, scene), std::invalid_argument);
  }
}

}  // namespace hapticd::test
