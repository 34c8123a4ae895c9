// Playing through the whole tick: what plucks a string and what does not. Hovering, slow lifts and
// trembling hands are silent; a pluck sounds once.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/math/elementary.h"
#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// Where the tests touch the string along its axis, m.
constexpr double kPlace = 0.33;

/// A hand that trembles by 0.1 mm at 8 to 12 Hz in every direction, read by an encoder that counts
/// in 20 um and errs by one count.
class TremblingHand {
 public:
  explicit TremblingHand(std::uint64_t seed) : random_(seed) {
    for (int k = 0; k < 3; ++k) {
      frequency_[k] = random_.uniform(8.0, 12.0);
      phase_[k] = random_.uniform();
    }
  }
  Vector3 at(const Vector3& p, double t) {
    constexpr double kCount = 20e-6;
    constexpr double kTremor = 0.1e-3;
    Vector3 out;
    for (int k = 0; k < 3; ++k) {
      const double turns = frequency_[k] * t + phase_[k];
      const double swing = kTremor * sin_cos(2.0 * kPi * (turns - std::floor(turns))).sin;
      const double error = kCount * random_.uniform(-1.0, 1.0);
      out[k] = kCount * std::floor((p[k] + swing + error) / kCount + 0.5);
    }
    return out;
  }

 private:
  SplitMix64 random_;
  Vector3 frequency_{0, 0, 0};
  Vector3 phase_{0, 0, 0};
};

/// Holds a trembling hand where it just touches string 0 from above, for 10 s.
void hover(Instrument& guqin, std::uint64_t seed) {
  TremblingHand hand(seed);
  const Vector3 touching(kPlace, felt_distance(guqin), 0.0);
  guqin.glide(touching, 0.1, [](const SimulationTick&) {});
  for (int k = 0; k < 10'000; ++k) guqin.tick(hand.at(touching, 1e-3 * k));
}

/// From above down beside the string, across under its height, and up again.
void pluck(Instrument& guqin) {
  const double speed = 0.3;
  const auto nothing = [](const SimulationTick&) {};
  const double z = guqin.p_WH.z() > 0.0 ? 0.012 : -0.012;
  guqin.glide({kPlace, 0.02, z}, speed, nothing);
  guqin.glide({kPlace, -2e-3, z}, speed, nothing);
  guqin.glide({kPlace, -2e-3, -z}, speed, nothing);
  guqin.glide({kPlace, 0.02, -z}, speed, nothing);
}

}  // namespace

TEST_CASE("a trembling hand that hovers on a string for ten seconds plays no tone") {
  for (Preset preset : all_presets()) {
    for (const bool vibration : {true, false}) {
      preset.options.vibration = vibration;
      for (std::int64_t i = scaled(30); i > 0; --i) {
        Instrument guqin(1, preset.string, preset.options);
        guqin.p_WH = {kPlace, 0.02, 0.0};
        guqin.tick(guqin.p_WH);
        hover(guqin, static_cast<std::uint64_t>(i));
        CAPTURE(std::string(preset.name));
        CHECK(count(guqin.events, StringEventKind::kTouch) > 0);
        CHECK(count(guqin.events, StringEventKind::kTone) == 0);
        CHECK(count(guqin.events, StringEventKind::kRelease) == 0);
      }
    }
  }
}

TEST_CASE("hovering on a string that rings plays no second tone, and a pluck after it plays one") {
  for (const Preset& preset : all_presets()) {
    Instrument guqin(1, preset.string, preset.options);
    guqin.tick({kPlace, 0.02, -0.012});
    pluck(guqin);
    CAPTURE(std::string(preset.name));
    CHECK(count(guqin.events, StringEventKind::kTone) == 1);
    hover(guqin, 5);
    CHECK(count(guqin.events, StringEventKind::kTone) == 1);
    pluck(guqin);
    CHECK(count(guqin.events, StringEventKind::kTone) == 2);
  }
}

TEST_CASE("a slow lift of a wave leaves at most two percent, of any other string the deflection") {
  double loudest = 0.0;
  for (const Preset& preset : all_presets()) {
    for (const double seconds : {1.0, 3.0}) {
      Instrument guqin(1, preset.string, preset.options);
      const double touching = felt_distance(guqin);
      const auto nothing = [](const SimulationTick&) {};
      guqin.tick({kPlace, 0.02, 0.5e-3});
      guqin.glide({kPlace, touching - 4e-3, 0.5e-3}, 0.1, nothing);
      // Until the press itself has died away under the finger.
      for (int k = 0; k < 2000; ++k) guqin.tick(guqin.p_WH);
      const double deflection = guqin.reading(0)->radius_growth;
      guqin.glide({kPlace, touching, 0.5e-3}, 4e-3 / seconds, nothing);
      guqin.glide({kPlace, 0.02, 0.5e-3}, 0.1, nothing);
      CAPTURE(std::string(preset.name));
      CHECK(deflection > 2e-3);
      CHECK(count(guqin.events, StringEventKind::kRelease) == 1);
      const auto tones = of_kind(guqin.events, StringEventKind::kTone);
      CHECK(tones.size() <= 1);
      if (!sounds(preset)) {
        REQUIRE(tones.size() == 1);
        CHECK(tones[0].amplitude == within(deflection, 0.02));
        continue;
      }
      for (const StringEvent& tone : tones) {
        loudest = std::max(loudest, tone.amplitude / deflection);
        CHECK(tone.amplitude <= 0.02 * deflection);
      }
    }
  }
  MESSAGE("loudest slow lift of a wave: " << loudest * 100.0 << " % of the deflection");
}

TEST_CASE("five plucks give five releases and five tones") {
  for (const Preset& preset : all_presets()) {
    Instrument guqin(1, preset.string, preset.options);
    guqin.tick({kPlace, 0.02, -0.012});
    for (int k = 0; k < 5; ++k) {
      pluck(guqin);
      // A wave that still swings strikes the finger on its way.
      for (int wait = 0; wait < 3000 && sounds(preset); ++wait) guqin.tick(guqin.p_WH);
    }
    CAPTURE(std::string(preset.name));
    CHECK(count(guqin.events, StringEventKind::kTouch) == 5);
    CHECK(count(guqin.events, StringEventKind::kPress) == 5);
    CHECK(count(guqin.events, StringEventKind::kLeave) == 0);
    CHECK(count(guqin.events, StringEventKind::kRelease) == 5);
    CHECK(count(guqin.events, StringEventKind::kTone) == 5);
  }
}

}  // namespace hapticd::test
