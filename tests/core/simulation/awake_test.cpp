// Which strings the tick looks at: those touched or ringing, and no other.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "tests/core/simulation/simulation_fixture.h"

namespace hapticd::test {
namespace {

const auto kNothing = [](const SimulationTick&) {};

}  // namespace

TEST_CASE("a hundred strings that nobody touches stay asleep") {
  for (const Preset& preset : all_presets()) {
    CAPTURE(std::string(preset.name));
    Instrument guqin(100, preset.string, preset.options);
    guqin.tick({0.3, 0.03, 0.0});
    guqin.glide({0.3, 0.03, 1.98}, 1.0, [](const SimulationTick& output) {
      CHECK(output.strings().empty());
      CHECK(output.events().empty());
    });
    for (int string = 0; string < 100; ++string) CHECK(guqin.reading(string) == nullptr);
  }
}

TEST_CASE("readings are of the strings touched or ringing, in ascending order, until these sleep") {
  for (const Preset& preset : all_presets()) {
    CAPTURE(std::string(preset.name));
    Instrument guqin(100, preset.string, preset.options);
    // From the last of five strings to the first.
    guqin.tick({0.3, -3e-3, 0.09});
    guqin.glide({0.3, -3e-3, -0.01}, 0.5, [&](const SimulationTick& output) {
      for (std::size_t k = 0; k < output.strings().size(); ++k) {
        CHECK(output.strings()[k].string < 5);
        if (k > 0) CHECK(output.strings()[k].string > output.strings()[k - 1].string);
      }
    });
    CHECK(guqin.output().strings().size() == 5);
    for (const StringTick& reading : guqin.output().strings()) {
      CHECK(reading.phase >= StringPhase::kFundamental);
      CHECK_FALSE(reading.touched);
      CHECK(reading.radius_growth > 0.0);
    }
    for (int k = 0; k < 5000 && !guqin.output().strings().empty(); ++k) guqin.tick(guqin.p_WH);
    CHECK(guqin.output().strings().empty());
    for (int string = 0; string < 100; ++string) CHECK(guqin.reading(string) == nullptr);
  }
}

TEST_CASE("one finger across three strings presses, arms and plucks each of them") {
  for (const Preset& preset : all_presets()) {
    // A line under the middle of a rigid tool takes all its weight: only strings that yield share.
    if (preset.string.model == StringContact::kStraight) continue;
    CAPTURE(std::string(preset.name));
    // A flat tool of three spheres 20 mm apart.
    Instrument guqin(3, preset.string, preset.options,
                     {{{0.0, 0.0, 0.0}, kFingertip},
                      {{0.0, 0.0, 0.02}, kFingertip},
                      {{0.0, 0.0, 0.04}, kFingertip}});
    guqin.tick({0.3, -3e-3, -0.009});
    std::size_t most = 0;
    guqin.glide({0.3, -3e-3, 0.009}, 0.5, [&](const SimulationTick& output) {
      most = std::max(most, output.tool(0).strings.size());
    });
    CHECK(most == 3);
    CHECK(count(guqin.events, StringEventKind::kTouch) == 3);
    CHECK(count(guqin.events, StringEventKind::kPress) == 3);
    CHECK(count(guqin.events, StringEventKind::kRelease) == 3);
    CHECK(count(guqin.events, StringEventKind::kTone) == 3);
    const auto tones = of_kind(guqin.events, StringEventKind::kTone);
    for (const StringEvent& tone : tones) {
      const double tuning = kTuning[static_cast<std::size_t>(tone.string)];
      // A wave that swings is as much sharper as that stretches it.
      CHECK(tone.frequency >= tuning);
      CHECK(tone.frequency <= (sounds(preset) ? 1.01 * tuning : tuning));
    }
    guqin.glide({0.3, -3e-3, 0.009}, 0.5, kNothing);
  }
}

}  // namespace hapticd::test
