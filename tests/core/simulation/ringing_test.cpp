// Strings that ring while a finger comes back: plucks in quick succession, a second pluck of a
// ringing string, and the envelope of the vibration, which is touched before the string is.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kPlace = 0.33;
constexpr double kDepth = 2e-3;

const auto kNothing = [](const SimulationTick&) {};

/// Past the string under its height at `speed`, to 6 mm on the other side: 1.1 mm clear of it; of
/// a wave to 12 mm, where it does not strike the finger as it swings.
void cross(Instrument& guqin, double speed) {
  const double aside = guqin.scene().instrument.modes > 0 ? 12e-3 : 6e-3;
  const double z = guqin.p_WH.z() > 0.0 ? -aside : aside;
  guqin.glide({kPlace, guqin.p_WH.y(), z}, speed, kNothing);
}

Instrument below_the_string(const Preset& preset) {
  Instrument guqin(1, preset.string, preset.options);
  guqin.tick({kPlace, -kDepth, -6e-3});
  return guqin;
}

/// A string that rings, with the finger clear above it.
Instrument ringing(const Preset& preset) {
  Instrument guqin = below_the_string(preset);
  guqin.tick({kPlace, -kDepth, -6e-3});
  cross(guqin, 1.0);
  guqin.glide({kPlace, -kDepth, 20e-3}, 1.0, kNothing);
  guqin.glide({kPlace, 20e-3, 20e-3}, 1.0, kNothing);
  guqin.glide({kPlace, 20e-3, 0.0}, 1.0, kNothing);
  return guqin;
}

}  // namespace

TEST_CASE(
    "two plucks within the refractory time are two releases and one tone, and energies do not "
    "add") {
  for (const Preset& preset : all_presets()) {
    Instrument guqin = below_the_string(preset);
    CAPTURE(std::string(preset.name));
    // A wave is let go of once it has been without force for a while.
    const auto pluck = [&] {
      cross(guqin, 2.0);
      for (int k = 0; k < 4 && sounds(preset); ++k) guqin.tick(guqin.p_WH);
      return guqin.energy(0);
    };
    const double first = pluck();
    const double second = pluck();
    const auto releases = of_kind(guqin.events, StringEventKind::kRelease);
    REQUIRE(releases.size() == 2);
    CHECK(releases[1].t_ns - releases[0].t_ns < 20'000'000);
    CHECK(count(guqin.events, StringEventKind::kTone) == 1);
    // The second pluck is the mirror image of the first: it leaves as much, not twice as much.
    // What a wave then does depends on how it swings as it is met.
    CHECK(first > 0.0);
    if (!sounds(preset)) {
      CHECK(second > 0.5 * first);
      CHECK(second < 1.2 * first);
    }
    // Later than that it sounds again.
    if (sounds(preset)) {
      // Once it is still: until then it would strike the finger.
      const Vector3 place = guqin.p_WH;
      guqin.glide({kPlace, -30e-3, place.z()}, 1.0, kNothing);
      for (int k = 0; k < 3000; ++k) guqin.tick(guqin.p_WH);
      guqin.glide(place, 1.0, kNothing);
    }
    for (int k = 0; k < 30; ++k) guqin.tick(guqin.p_WH);
    pluck();
    CHECK(count(guqin.events, StringEventKind::kRelease) == 3);
    CHECK(count(guqin.events, StringEventKind::kTone) == 2);
  }
}

TEST_CASE("a light pluck of a string that rings strongly leaves it the stronger energy") {
  // The paper's finger does not damp.
  const Preset preset = paper_preset();
  Instrument guqin = below_the_string(preset);
  cross(guqin, 1.0);
  const double strong = guqin.energy(0);
  const std::int64_t then = guqin.t_ns;
  // By 0.6 mm, from the other side.
  guqin.glide({kPlace, -felt_distance(guqin) + 0.6e-3, guqin.p_WH.z()}, 1.0, kNothing);
  cross(guqin, 1.0);
  CHECK(count(guqin.events, StringEventKind::kRelease) == 2);
  const double seconds = 1e-9 * static_cast<double>(guqin.t_ns - then);
  const double left = strong * std::exp(-2.0 * seconds / preset.string.decay);
  CHECK(guqin.energy(0) <= left * (1.0 + 1e-9));
  CHECK(guqin.energy(0) > 0.5 * left);
}

TEST_CASE("a ringing string that is touched, pressed and let go again sounds again") {
  for (const Preset& preset : all_presets()) {
    Instrument guqin = below_the_string(preset);
    CAPTURE(std::string(preset.name));
    cross(guqin, 0.5);
    REQUIRE(guqin.reading(0) != nullptr);
    CHECK(guqin.reading(0)->phase >= StringPhase::kFundamental);
    cross(guqin, 0.5);
    const auto touches = of_kind(guqin.events, StringEventKind::kTouch);
    REQUIRE(touches.size() >= 2);
    CHECK_FALSE(touches[0].ringing);
    CHECK(touches[1].ringing);
    const int presses = count(guqin.events, StringEventKind::kPress);
    CHECK(count(guqin.events, StringEventKind::kRelease) == presses);
    // A wave may strike the finger that comes to press it.
    if (!sounds(preset)) {
      CHECK(touches.size() == 2);
      CHECK(presses == 2);
    }
    CHECK(count(guqin.events, StringEventKind::kTone) == 2);
  }
}

TEST_CASE("a finger that enters the envelope of a vibration touches the ringing string") {
  double latest = 0.0;
  for (const Preset& preset : fundamental_presets()) {
    for (int tenths = 2; tenths <= 9; ++tenths) {
      Instrument guqin = ringing(preset);
      CAPTURE(std::string(preset.name));
      CAPTURE(tenths);
      const auto tones = of_kind(guqin.events, StringEventKind::kTone);
      REQUIRE(tones.size() == 1);
      guqin.events.clear();
      const auto envelope = [&](double t_ns) {
        return tones[0].amplitude *
               std::exp(-1e-9 * (t_ns - static_cast<double>(tones[0].t_ns)) / preset.string.decay);
      };
      // Down to that share of the envelope, and stay.
      const double speed = 0.05;
      const auto felt = [&](const Vector3& p) { return p.y() - felt_distance(guqin); };
      guqin.glide({kPlace, felt_distance(guqin) + 6e-3, 0.0}, 0.5, kNothing);
      double before = felt(guqin.p_WH);
      while (felt(guqin.p_WH) > 0.1 * tenths * envelope(static_cast<double>(guqin.t_ns))) {
        before = felt(guqin.p_WH);
        guqin.tick(Vector3(guqin.p_WH - Vector3(0.0, speed * 1e-3, 0.0)));
      }
      REQUIRE(before > 0.0);
      const auto touches = of_kind(guqin.events, StringEventKind::kTouch);
      // More than one where the envelope dies away faster under the finger than the finger follows.
      REQUIRE_FALSE(touches.empty());
      for (const StringEvent& touch : touches) CHECK(touch.ringing);
      CHECK(touches[0].force == 0.0);
      CHECK(touches[0].normal_speed == within(speed, 1e-6));
      // Where the hand was at that instant the envelope was, too.
      const double height =
          felt(guqin.p_WH) + speed * 1e-9 * static_cast<double>(guqin.t_ns - touches[0].t_ns);
      const double error = (height - envelope(static_cast<double>(touches[0].t_ns))) / speed;
      latest = std::max(latest, std::abs(error));
      CHECK(std::abs(error) < 0.2e-3);
      CHECK(count(guqin.events, StringEventKind::kTone) == 0);
    }
  }
  MESSAGE("largest error of the instant of a touch of the envelope: " << latest * 1e6 << " us");
}

TEST_CASE("a finger that comes into the envelope from afar within a tick is seen in that tick") {
  for (const Preset& preset : fundamental_presets()) {
    for (const double margin : {5e-3, 0.5e-3}) {
      Instrument guqin = ringing(preset);
      guqin.scene().options.margin = margin;
      CAPTURE(std::string(preset.name));
      CAPTURE(margin);
      const double height = felt_distance(guqin) + 0.8 * guqin.reading(0)->radius_growth;
      guqin.events.clear();
      guqin.glide({kPlace, height + 10e-3, 0.0}, 0.5, kNothing);
      CHECK(guqin.events.empty());
      guqin.tick({kPlace, height, 0.0});
      const auto touches = of_kind(guqin.events, StringEventKind::kTouch);
      REQUIRE(touches.size() == 1);
      CHECK(touches[0].ringing);
      CHECK(touches[0].t_ns > guqin.t_ns - guqin.dt_ns);
      CHECK(touches[0].t_ns <= guqin.t_ns);
      CHECK(touches[0].normal_speed == within(10.0, 1e-6));
    }
  }
}

TEST_CASE("a finger in the envelope is struck and never drawn, and damps as touch_decay says") {
  for (const Preset& preset : fundamental_presets()) {
    for (int tenths = 2; tenths <= 9; ++tenths) {
      Instrument guqin = ringing(preset);
      CAPTURE(std::string(preset.name));
      CAPTURE(tenths);
      const double growth = guqin.reading(0)->radius_growth;
      guqin.glide({kPlace, felt_distance(guqin) + 0.1 * tenths * growth, 0.0}, 0.5, kNothing);
      REQUIRE(guqin.reading(0)->touched);
      double strongest = 0.0;
      int damped_ticks = 0;
      const double keep = std::exp(-1e-3 / preset.string.touch_decay);
      while (guqin.reading(0) != nullptr && guqin.reading(0)->touched && damped_ticks < 20) {
        const StringTick last = *guqin.reading(0);
        guqin.tick(guqin.p_WH);
        if (guqin.reading(0) == nullptr || !guqin.reading(0)->touched) break;
        ++damped_ticks;
        const StringTick& now = *guqin.reading(0);
        CHECK(now.vibration_force >= 0.0);
        CHECK(now.radius_growth == within(last.radius_growth * keep, 1e-9));
        strongest = std::max(strongest, now.vibration_force);
      }
      CHECK(damped_ticks > 0);
      if (tenths <= 4) CHECK(strongest > 0.0);
      CHECK(count(guqin.events, StringEventKind::kRelease) == 1);
    }
  }
}

TEST_CASE("a finger that leaves the envelope lets the string ring on as long as before") {
  for (const Preset& preset : fundamental_presets()) {
    Instrument guqin = ringing(preset);
    CAPTURE(std::string(preset.name));
    const double growth = guqin.reading(0)->radius_growth;
    guqin.glide({kPlace, felt_distance(guqin) + 0.5 * growth, 0.0}, 0.5, kNothing);
    guqin.glide({kPlace, 20e-3, 0.0}, 1.0, kNothing);
    CHECK(count(guqin.events, StringEventKind::kLeave) == 1);
    CHECK(count(guqin.events, StringEventKind::kTone) == 1);
    REQUIRE(guqin.reading(0) != nullptr);
    const double before = guqin.reading(0)->radius_growth;
    for (int k = 0; k < 100; ++k) guqin.tick(guqin.p_WH);
    REQUIRE(guqin.reading(0) != nullptr);
    const double keep = std::exp(-0.1 / preset.string.decay);
    CHECK(guqin.reading(0)->radius_growth == within(before * keep, 1e-9));
    CHECK_FALSE(guqin.reading(0)->touched);
    CHECK(guqin.reading(0)->vibration_force == 0.0);
  }
}

TEST_CASE("a wave strikes a finger that comes into its swing, and never draws it") {
  for (const Preset& preset : all_presets()) {
    if (!sounds(preset)) continue;
    for (int tenths = 1; tenths <= 3; ++tenths) {
      Instrument guqin = ringing(preset);
      CAPTURE(std::string(preset.name));
      CAPTURE(tenths);
      const double before = guqin.energy(0);
      const double growth = guqin.reading(0)->radius_growth;
      double strongest = 0.0;
      double weakest = 0.0;
      const auto look = [&](const SimulationTick&) {
        strongest = std::max(strongest, guqin.normal_force(0));
        weakest = std::min(weakest, guqin.normal_force(0));
      };
      guqin.events.clear();
      guqin.glide({kPlace, felt_distance(guqin) + 0.1 * tenths * growth, 0.0}, 0.5, look);
      for (int k = 0; k < 100; ++k) look(guqin.tick(guqin.p_WH));
      CHECK(strongest > 0.0);
      CHECK(weakest >= 0.0);
      const auto touches = of_kind(guqin.events, StringEventKind::kTouch);
      REQUIRE_FALSE(touches.empty());
      CHECK(touches[0].ringing);
      CHECK(touches[0].force > 0.0);
      CHECK(guqin.energy(0) < before);
      CHECK(count(guqin.events, StringEventKind::kTone) == 0);
    }
  }
}

}  // namespace hapticd::test
