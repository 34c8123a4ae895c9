// Long runs in virtual time (tests/EXTREMES.md): 1e8 ticks by tests/long, a hundredth in the
// usual build. Truth: a force that is the same in every period, unit quaternions, and where strings
// ring and stick, play that ends as it began.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "tests/scenario/extremes/extreme_scene.h"
#include "tests/support/scale.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

constexpr int kPeriod = 500;
/// Periods at the beginning and at the end that are compared.
constexpr std::int64_t kEnds = 8;

/// 1e8 at scale 1, 1e6 in the usual build, 1e4 under a sanitizer: the scale twice.
std::int64_t periods() { return scaled(scaled(100'000'000)) / kPeriod + 3; }

struct Course {
  Vector3 first_f{0, 0, 0};  ///< at the end of the second period
  Vector3 last_f{0, 0, 0};
  double worst_norm = 0.0;     ///< ||q| - 1| of G
  double largest_force = 0.0;  ///< N
  double early_force = 0.0;    ///< largest of the first kEnds periods, N
  double late_force = 0.0;     ///< largest of the last kEnds periods, N
  std::int64_t tones = 0;
  std::int64_t ticks = 0;
};

/// Plays `cycle` again and again.
Course play_long(const Scene& scene, const std::vector<Pose>& cycle) {
  OwnedSimulation play = scene.simulate();
  SimulationTick output;
  Course course;
  std::int64_t tick = 0;
  const std::int64_t count = periods();
  for (std::int64_t period = 0; period < count; ++period) {
    for (const Pose& X_WH : cycle) {
      ++tick;
      output.step(*play.simulation, {tick * 1'000'000, to_array(X_WH.p), to_array(X_WH.q)});
      const double force = output.tool(0).F_computed_H_W.f.norm();
      course.largest_force = std::max(course.largest_force, force);
      if (period < kEnds) course.early_force = std::max(course.early_force, force);
      if (period >= count - kEnds) course.late_force = std::max(course.late_force, force);
      for (const StringEvent& event : output.events()) {
        if (event.kind == StringEventKind::kTone) ++course.tones;
      }
    }
    const RenderedTool& now = output.tool(0);
    if (period == 1) course.first_f = now.F_computed_H_W.f;
    course.last_f = now.F_computed_H_W.f;
    course.worst_norm = std::max(course.worst_norm, std::abs(now.X_WG.q.norm() - 1.0));
  }
  course.ticks = tick;
  return course;
}

const std::array<Computation, 2> kBoth{{{3, StringPreset::kPaper}, {3, StringPreset::kDeflecting}}};

}  // namespace

TEST_CASE("a hundred million ticks of a hand at rest on a string change nothing of its force") {
  for (const Computation& computation : kBoth) {
    CAPTURE(computation.name());
    SceneDescription description = crowded_scene(computation, 1);
    description.instrument.modes = 0;
    const Scene scene(std::move(description));
    const std::vector<Pose> cycle(kPeriod, Pose{{1, 0, 0, 0}, {0.3, kTip - 1e-3, 0.0}});
    const Course course = play_long(scene, cycle);
    MESSAGE(computation.name(), ": ", course.ticks, " ticks");
    CHECK((course.last_f - course.first_f).norm() < 1e-9);
    CHECK(course.first_f.norm() > 0.05);
    CHECK(course.worst_norm < 1e-12);
  }
}

TEST_CASE("a hundred million ticks of a hand that goes round and round come back to its force") {
  for (const Computation& computation : kBoth) {
    CAPTURE(computation.name());
    SceneDescription description = crowded_scene(computation, 1);
    // What sticks and what rings remembers its past; this is about drift of numbers.
    description.instrument.friction = false;
    description.instrument.vibration = false;
    description.instrument.modes = 0;
    const Scene scene(std::move(description));
    std::vector<Pose> cycle;
    cycle.reserve(kPeriod);
    for (int i = 0; i < kPeriod; ++i) {
      const double s = std::sin(2.0 * kPi * i / kPeriod);
      cycle.push_back({exp_rotation({0.01 * s, 0.02 * s, 0.0}),
                       {0.3 + 2e-3 * s, kTip - 1e-3 + 3e-4 * s, 1e-4 * s}});
    }
    const Course course = play_long(scene, cycle);
    MESSAGE(computation.name(), ": ", course.ticks, " ticks");
    CHECK((course.last_f - course.first_f).norm() < 1e-9);
    CHECK(course.first_f.norm() > 0.05);
    CHECK(course.worst_norm < 1e-12);
  }
}

TEST_CASE(
    "a hundred million ticks of playing with friction, vibration and modes end as they began") {
  for (const Computation& computation : kBoth) {
    CAPTURE(computation.name());
    SceneDescription description = crowded_scene(computation, 1);
    description.instrument.friction = true;
    description.instrument.vibration = true;
    description.instrument.modes = 16;
    const Scene scene(std::move(description));
    // Down on the string, along and across it, off its side, and round to where it began: a pluck
    // in every period, which what has rung since changes a little.
    std::vector<Pose> cycle;
    cycle.reserve(kPeriod);
    for (int i = 0; i < kPeriod; ++i) {
      const double turn = 2.0 * kPi * i / kPeriod;
      cycle.push_back({exp_rotation({0.01 * std::sin(turn), 0.02 * std::sin(turn), 0.0}),
                       {0.3 + 5e-3 * std::sin(2.0 * turn), 4e-3 + 3e-3 * std::cos(turn),
                        8e-3 * std::sin(turn)}});
    }
    const Course course = play_long(scene, cycle);
    MESSAGE(computation.name(), ": ", course.ticks, " ticks, largest force ", course.largest_force,
            " N, ", course.tones, " tones");
    CHECK(course.worst_norm < 1e-12);
    // The hand is never more than 12 mm from a free tool.
    CHECK(course.largest_force < 1000.0 * 12e-3);
    CHECK(course.largest_force > 0.3);
    // A string that still rings meets each stroke a little otherwise.
    CHECK(course.late_force < 1.1 * course.early_force);
    CHECK(course.late_force > 0.9 * course.early_force);
    CHECK(course.tones > course.ticks / kPeriod / 4);
  }
}

}  // namespace hapticd::test
