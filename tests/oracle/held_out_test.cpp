// The errors that levels of quality state, on gestures that the study did not choose them by; and
// what must hold of the levels on any gesture. Judged by counts and forces alone.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "core/contact/tick_work.h"
#include "core/scene/quality.h"
#include "server/scene_io/scene_defaults.h"
#include "server/scene_io/scene_loader.h"
#include "tests/oracle/study_report.h"
#include "tests/support/scale.h"
#include "tests/support/skip.h"

namespace hapticd::test {
namespace {

/// As HELD_OUT of hapticd_lab/tradeoff_plan.py: the study's own seeds begin with 1.
constexpr std::uint64_t kHeldOut = 100'001;
/// What a stated bound may be off on gestures it was not made from.
constexpr double kAllowance = 1.2;
/// More quality may have so much more error: the tool comes to another place.
constexpr double kMoreError = 1.05;
/// Relative errors below are rounding of the truth.
constexpr double kMinError = 1e-7;
constexpr double kDeepest_m = 1e-6;

struct Level {
  double error_square = 0.0;
  double truth_square = 0.0;
  double work = 0.0;
  double deepest_gap = 1.0;

  [[nodiscard]] double error() const {
    return std::max(kMinError, std::sqrt(error_square / truth_square));
  }
};
using Levels = std::array<Level, kQualityLevels>;

std::unique_ptr<LoadedScene> shipped(const char* name) {
  LoadOptions load;
  load.paths = {{HAPTICD_SCENES_DIR}, {HAPTICD_MODELS_DIR}};
  return load_scene(name, load).loaded;
}

/// All levels on held-out gestures at both speeds of the study.
Levels play_levels(const Scene& scene, int gestures) {
  Levels levels;
  PathRun judge(scene);
  for (int k = 0; k < gestures; ++k) {
    const std::uint64_t seed = kHeldOut + static_cast<std::uint64_t>(k);
    for (const double speed : {0.05, 0.5}) {
      const StudyGesture gesture = choose_study_gesture(scene, 0, judge.judge(), seed, speed);
      StudySetting setting;
      setting.options = truth_options(scene.description());
      const auto truth = play_study(scene, 0, setting, gesture, nullptr);
      for (int level = 0; level < kQualityLevels; ++level) {
        setting = parse_setting("l:level=" + std::to_string(level), scene.description());
        const auto run = play_study(scene, 0, setting, gesture, &judge);
        const StudyErrors errors = compare(run, truth, 1.0);
        Level& sum = levels[static_cast<std::size_t>(level)];
        sum.error_square += errors.felt_square;
        sum.truth_square += errors.truth_square;
        for (const StudyTick& tick : run) {
          sum.work += static_cast<double>(tick_work(tick.counts));
          sum.deepest_gap = std::min(sum.deepest_gap, tick.path_gap_m);
        }
      }
    }
  }
  return levels;
}

/// Adds a run's errors to `level`, and the work of its ticks in touch to `work`.
void add(const std::vector<StudyTick>& run, const std::vector<StudyTick>& truth, Level& level,
         Histogram& work) {
  const StudyErrors errors = compare(run, truth, 1.0);
  level.error_square += errors.felt_square;
  level.truth_square += errors.truth_square;
  for (const StudyTick& tick : run) {
    if (tick.touches) count_value(static_cast<double>(tick_work(tick.counts)), work);
  }
}

}  // namespace

TEST_CASE("on gestures held out, levels keep their stated errors to 1.2 times, and enter nothing") {
  for (const char* name : {"bunny", "cabin", "single_string", "strings_100"}) {
    CAPTURE(name);
    const auto loaded = shipped(name);
    if (loaded == nullptr) {
      skip("the models of the scene are not made here");
      return;
    }
    const Levels levels = play_levels(*loaded->scene, static_cast<int>(scaled(20)));
    for (int level = 0; level < kQualityLevels; ++level) {
      CAPTURE(level);
      const Level& here = levels[static_cast<std::size_t>(level)];
      CHECK(here.error() <= kAllowance * quality_of(level).force_error);
      CHECK(here.deepest_gap >= -kDeepest_m);
      if (level == 0) continue;
      const Level& below = levels[static_cast<std::size_t>(level) - 1];
      CHECK(here.error() <= kMoreError * below.error());
      CHECK(here.work >= below.work);
    }
  }
}

TEST_CASE("with coarser and finer leaves, levels span 10 times the work and 100 times the error") {
  const auto fine = shipped("bunny_fine");
  const auto coarse = shipped("bunny_coarse");
  REQUIRE(fine != nullptr);
  REQUIRE(coarse != nullptr);
  const Scene& scene = *fine->scene;
  PathRun judge(scene);
  Level least, most;
  Histogram least_work, most_work;
  // Of the study: in these the bunny slips over an edge, where a budget is hardest to keep.
  for (const std::uint64_t seed : {3U, 4U}) {
    const StudyGesture gesture = choose_study_gesture(scene, 0, judge.judge(), seed, 0.5);
    StudySetting setting;
    setting.options = truth_options(scene.description());
    const auto truth = play_study(scene, 0, setting, gesture, nullptr);
    const auto cheap =
        play_study(*coarse->scene, 0, parse_setting("l:level=0", coarse->scene->description()),
                   gesture, nullptr);
    const auto exact =
        play_study(scene, 0, parse_setting("l:level=4", scene.description()), gesture, nullptr);
    add(cheap, truth, least, least_work);
    add(exact, truth, most, most_work);
  }
  CHECK(quantile(most_work, 0.99) >= 10.0 * quantile(least_work, 0.99));
  CHECK(least.error() >= 100.0 * most.error());
}

TEST_CASE(
    "an error that is asked for is met on gestures held out, by the cheapest level that can") {
  const auto loaded = shipped("single_string");
  REQUIRE(loaded != nullptr);
  const Levels levels = play_levels(*loaded->scene, std::max(2, static_cast<int>(scaled(20))));
  for (const double wanted : {0.5, 0.1, 0.01, 1e-3, 1e-4}) {
    CAPTURE(wanted);
    const int level = quality_for(wanted);
    if (!quality_offers(wanted)) continue;
    CHECK(levels[static_cast<std::size_t>(level)].error() <= kAllowance * wanted);
    if (level > 0) CHECK(quality_of(level - 1).force_error > wanted);
  }
}

TEST_CASE("an error that no level promises is doubted aloud, and the most exact level played") {
  LoadOptions load;
  load.paths = {{HAPTICD_SCENES_DIR}, {HAPTICD_MODELS_DIR}};
  load.quality.quality.emplace().set_max_force_error(1e-12);
  const LoadResult result = load_scene("single_string", load);
  REQUIRE(result.loaded != nullptr);
  CHECK(quality_level(result.loaded->message.quality()) == kQualityLevels - 1);
  const auto about = [](const SceneProblem& problem) {
    return problem.doubt && problem.field == "quality.max_force_error";
  };
  CHECK(std::count_if(result.problems.begin(), result.problems.end(), about) == 1);
  load.quality.quality->set_max_force_error(0.5);
  const LoadResult easy = load_scene("single_string", load);
  CHECK(std::none_of(easy.problems.begin(), easy.problems.end(), about));
}

}  // namespace hapticd::test
