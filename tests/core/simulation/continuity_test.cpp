// The force of the whole tick is continuous: it changes no faster than the hand presses and the
// string swings; where a string slips off it is what the exact statics leaves. And what a player
// feels in the paper's Fig. 15 and 17: a string touched while it vibrates, and a slide along a
// string.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/math/elementary.h"
#include "tests/core/simulation/force_watch.h"
#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kPlace = 0.33;
constexpr double kTick = 1e-3;
const auto kNothing = [](const SimulationTick&) {};

/// Amplitude of the wave of `frequency` (Hz) in samples 1 ms apart, less their mean.
double wave_amplitude(const std::vector<double>& samples, double frequency) {
  double mean = 0.0;
  for (const double sample : samples) mean += sample / static_cast<double>(samples.size());
  double re = 0.0;
  double im = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double turns = frequency * kTick * static_cast<double>(k);
    const SinCos w = sin_cos(2.0 * kPi * (turns - std::floor(turns)));
    re += (samples[k] - mean) * w.cos;
    im += (samples[k] - mean) * w.sin;
  }
  return 2.0 * std::sqrt(re * re + im * im) / static_cast<double>(samples.size());
}

/// Frequency of the strongest wave between 20 and 400 Hz, to 0.1 Hz.
double strongest_frequency(const std::vector<double>& samples) {
  double best = 0.0;
  double strongest = 0.0;
  for (double frequency = 20.0; frequency < 400.0; frequency += 0.1) {
    const double amplitude = wave_amplitude(samples, frequency);
    if (amplitude > strongest) {
      strongest = amplitude;
      best = frequency;
    }
  }
  return best;
}

/// Forces of a finger that presses a string, leaves it suddenly, comes back while it vibrates and
/// stays: from the moment it stays.
struct Replay {
  std::vector<double> f_y;
  std::vector<double> f_z;
  double pressed = 0.0;  ///< force before it left, N
  double worst = 0.0;    ///< largest change of force over what is allowed
  int drop_ticks = 0;    ///< from the press to no force
};

Replay touch_while_vibrating(const Preset& preset, int ticks) {
  Instrument guqin(1, preset.string, preset.options);
  Replay replay;
  guqin.tick({kPlace, 0.012, 1.5e-3});
  ForceWatch watch(guqin, preset);
  const auto look = [&](const SimulationTick&) {
    replay.worst = std::max(replay.worst, watch.look());
  };
  guqin.glide({kPlace, 1.5e-3, 1.5e-3}, 0.1, look);
  for (int k = 0; k < 500; ++k) look(guqin.tick(guqin.p_WH));
  replay.pressed = guqin.output().tool(0).F_H_W.f.norm();
  guqin.glide({kPlace, 0.02, 1.5e-3}, 1.2, [&](const SimulationTick& output) {
    look(output);
    if (output.tool(0).F_H_W.f.norm() > 0.0) ++replay.drop_ticks;
  });
  guqin.glide({kPlace, 2e-3, 1.5e-3}, 0.5, look);
  for (int k = 0; k < ticks; ++k) {
    look(guqin.tick(guqin.p_WH));
    replay.f_y.push_back(guqin.output().tool(0).F_H_W.f.y());
    replay.f_z.push_back(guqin.output().tool(0).F_H_W.f.z());
  }
  return replay;
}

std::vector<double> part(const std::vector<double>& samples, int from, int to) {
  return {samples.begin() + from, samples.begin() + to};
}

}  // namespace

TEST_CASE("a string at rest is touched, pressed and left smoothly") {
  double worst = 0.0;
  for (const Preset& preset : all_presets()) {
    for (const double speed : {0.02, 0.1, 0.5, 1.2}) {
      Instrument guqin(1, preset.string, preset.options);
      guqin.tick({kPlace, 0.01, 1e-3});
      ForceWatch watch(guqin, preset);
      const auto look = [&](const SimulationTick&) { worst = std::max(worst, watch.look()); };
      guqin.glide({kPlace, 1.5e-3, 1e-3}, speed, look);
      guqin.glide({kPlace, 0.01, 1e-3}, speed, look);
    }
  }
  MESSAGE("largest change of force: " << worst << " of what is allowed");
  CHECK(worst <= 1.0);
}

TEST_CASE("the force of random play changes as the hand and the strings move, slips included") {
  double worst = 0.0;
  int lost = 0;
  const std::vector<Preset> presets = all_presets();
  for (std::int64_t i = scaled(320); i > 0; --i) {
    const Preset& preset = presets[static_cast<std::size_t>(i) % presets.size()];
    SplitMix64 random(static_cast<std::uint64_t>(i) + 4000);
    const int strings = 1 + static_cast<int>(random.below(3));
    Instrument guqin(strings, preset.string, preset.options);
    guqin.tick({0.5, 0.02, 0.0});
    ForceWatch watch(guqin, preset);
    const auto go = [&](const Vector3& to) {
      guqin.glide(to, 0.05 * std::pow(24.0, random.uniform()),
                  [&](const SimulationTick&) { worst = std::max(worst, watch.look()); });
    };
    double side = 1.0;
    for (int move = 0; move < 40; ++move) {
      const double x = random.uniform(0.1, 1.0);
      // Nearer to an axis the finger is on its way round the string.
      const double height = random.uniform(2.8e-3, 9e-3);
      go({x, side * height, 0.02 * random.uniform(-0.5, strings - 0.5)});
      if (!random.chance(0.3)) continue;
      const double gap = 0.02 * static_cast<double>(random.below(7)) - 0.01;
      go({x, side * height, gap});
      side = -side;
      go({x, side * height, gap});
    }
    lost += watch.lost();
  }
  MESSAGE("largest change of force: " << worst << " of what is allowed; " << lost
                                      << " times a string was let go");
  CHECK(worst <= 1.0);
  CHECK(lost > 20);
}

TEST_CASE("a string touched while it vibrates shakes the finger at its pitch, until that decays") {
  for (Preset preset : fundamental_presets()) {
    CAPTURE(std::string(preset.name));
    preset.string.frequency = 87.3;
    const Replay replay = touch_while_vibrating(preset, 1500);
    CHECK(replay.pressed > 0.3);
    CHECK(replay.drop_ticks <= 4);
    CHECK(replay.worst <= 1.0);
    // The paper's finger does not damp; a finger that does leaves two or three swings to judge by.
    const bool damps = preset.string.touch_decay < 0.1;
    const int window = damps ? 60 : 252;
    const std::vector<double> early = part(replay.f_y, 0, window);
    CHECK(std::abs(strongest_frequency(early) - 87.3) < (damps ? 3.0 : 0.5));
    CHECK(wave_amplitude(early, 87.3) > 0.02);
    CHECK(wave_amplitude(part(replay.f_z, 0, window), 87.3) > 0.01);
    if (!damps) {
      // 11 periods, and 11 periods twice as late.
      const double later = wave_amplitude(part(replay.f_y, 252, 378), 87.3);
      const double share = later / wave_amplitude(part(replay.f_y, 0, 126), 87.3);
      MESSAGE(std::string(preset.name) << ": decays to " << share);
      CHECK(share == within(std::exp(-0.252 / preset.string.decay), 0.05));
    }
    CHECK(wave_amplitude(part(replay.f_y, damps ? 200 : 1400, 1500), 87.3) < 0.02);
  }
}

TEST_CASE("a finger on a wave feels the longer part of it swing, at its pitch or at twice that") {
  for (Preset preset : all_presets()) {
    if (!sounds(preset)) continue;
    CAPTURE(std::string(preset.name));
    preset.string.frequency = 87.3;
    const Replay replay = touch_while_vibrating(preset, 400);
    CHECK(replay.worst <= 1.0);
    // The finger holds the string at 0.3 of its length, though not quite: it yields.
    const double parted = 87.3 / 0.7;
    const double felt = strongest_frequency(part(replay.f_y, 0, 100));
    MESSAGE(std::string(preset.name) << ": " << felt << " Hz");
    const double partial = felt < 1.5 * parted ? 1.0 : 2.0;
    CHECK(felt < 1.03 * partial * parted);
    CHECK(felt > 0.9 * partial * parted);
  }
}

TEST_CASE("a slide along one string keeps its force, and over the whole of it nothing drags") {
  double drag = 0.0;
  double worst = 0.0;
  for (const Preset& preset : all_presets()) {
    if (preset.options.friction) continue;
    for (const double speed : {0.1, 0.3, 1.0}) {
      Instrument guqin(1, preset.string, preset.options);
      guqin.tick({0.2, 0.012, 0.0});
      guqin.glide({0.2, felt_distance(guqin) - 2e-3, 0.0}, 0.1, kNothing);
      ForceWatch watch(guqin, preset);
      watch.look();
      Vector3 before = guqin.output().tool(0).F_H_W.f;
      // A bent string pushes towards its middle: what it takes on one side it gives on the other.
      double along = 0.0;
      double pressed = 0.0;
      guqin.glide({0.9, guqin.p_WH.y(), 0.0}, speed, [&](const SimulationTick& output) {
        const Vector3& f = output.tool(0).F_H_W.f;
        along += f.x();
        pressed += f.norm();
        worst = std::max(worst, (f - before).norm());
        before = f;
        CHECK(output.tool(0).strings.size() == 1);
      });
      drag = std::max(drag, std::abs(along) / pressed);
      CHECK(count(guqin.events, StringEventKind::kTouch) == 1);
      CHECK(count(guqin.events, StringEventKind::kRelease) == 0);
    }
  }
  MESSAGE("drag " << drag << " of the force, largest change in a tick " << worst << " N");
  CHECK(drag < 1e-3);
}

}  // namespace hapticd::test
