// What leaves is a number within [-1, 1], whatever is struck; and seven strings of level 1 are so
// far below it that nothing is changed of them. Adversaries: random chords, restrikes, levels,
// decays and gains, tones that are no numbers.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "clients/audio/audio_engine.h"
#include "clients/audio/dsp/limiter.h"
#include "clients/audio/render.h"
#include "tests/clients/audio/played.h"
#include "tests/clients/audio/temporary_folder.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::audio {
namespace {

constexpr double kRate_hz = 48000.0;
constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double peak_of(std::span<const float> sound) {
  double peak = 0.0;
  for (const float frame : sound) peak = std::max(peak, std::abs(static_cast<double>(frame)));
  return peak;
}

bool all_good(std::span<const float> sound) {
  return std::all_of(sound.begin(), sound.end(),
                     [](float frame) { return frame >= -1.0F && frame <= 1.0F; });
}

/// The scene of the seven open strings, and nothing played.
Score silent_score() {
  Score score = open_strings();
  score.resize(1);
  return score;
}

/// A pluck of level 1.
ScoreEntry pluck(std::int64_t t_ns, std::size_t string, double lambda = 0.1, double decay_s = 0.5) {
  ScoreEntry entry{t_ns, {}};
  v1::Tone& tone = *entry.item.mutable_tone();
  tone.set_t_ns(static_cast<std::uint64_t>(t_ns));
  tone.set_string_index(static_cast<std::uint32_t>(string));
  tone.set_frequency_hz(static_cast<float>(kZhengDiao[string].frequency_hz));
  tone.set_level(1.0F);
  tone.set_lambda(static_cast<float>(lambda));
  tone.set_decay_s(static_cast<float>(decay_s));
  return entry;
}

std::vector<float> rendered(const Score& score, ToneFiles* tones, RenderReport& report,
                            double gain = 1.0) {
  std::vector<float> sound;
  Sound settings = test::whole();
  settings.gain = gain;
  report = render(score, settings, tones, [&](std::span<const float> frames) {
    sound.insert(sound.end(), frames.begin(), frames.end());
  });
  return sound;
}

/// The shipped recordings.
struct Shipped {
  Shipped() { render_tone_files(folder.path().string(), kRate_hz); }
  test::TemporaryFolder folder;
  ToneFiles files{folder.path(), kRate_hz};
};

}  // namespace

TEST_CASE("the peaks of the seven strings of level 1 add up to less than the limiter's threshold") {
  Shipped shipped;
  for (ToneFiles* const tones : {&shipped.files, static_cast<ToneFiles*>(nullptr)}) {
    double sum = 0.0;
    for (std::size_t string = 0; string < std::size(kZhengDiao); ++string) {
      Score score = silent_score();
      score.push_back(pluck(0, string));
      RenderReport report;
      sum += peak_of(rendered(score, tones, report));
      CHECK_EQ(report.limited_s, 0.0);
    }
    CAPTURE(sum);
    CHECK(sum < kLimiterThreshold);
  }
}

TEST_CASE("seven strings of level 1 are left as they are, at once, at random and struck again") {
  Shipped shipped;
  test::SplitMix64 random(27);
  for (std::int64_t round = 0; round < test::scaled(40); ++round) {
    Score score = silent_score();
    std::int64_t at = 0;
    for (int strike = 0; strike < 4; ++strike) {
      for (std::size_t string = 0; string < std::size(kZhengDiao); ++string) {
        const std::int64_t spread = round == 0 ? 1 : 30 * kMillisecond_ns;
        score.push_back(
            pluck(at + static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(spread))),
                  string, random.uniform(0.1, 0.5), random.uniform(0.5, 3.0)));
      }
      at += static_cast<std::int64_t>(random.uniform(30.0, 500.0)) * kMillisecond_ns;
    }
    std::sort(score.begin() + 1, score.end(),
              [](const ScoreEntry& a, const ScoreEntry& b) { return a.t_ns < b.t_ns; });
    for (ToneFiles* const tones : {&shipped.files, static_cast<ToneFiles*>(nullptr)}) {
      RenderReport report;
      const auto sound = rendered(score, tones, report);
      CAPTURE(round);
      CHECK_EQ(report.played, 28);
      CHECK_EQ(report.limited_s, 0.0);
      CHECK(peak_of(sound) < kLimiterThreshold);
    }
  }
}

TEST_CASE("any number of strings, struck again at any pace, at any gain, never passes full scale") {
  test::SplitMix64 random(1024);
  Shipped shipped;
  double limited_s = 0.0;
  // Enough for some of them to be loud.
  const std::int64_t rounds = std::max<std::int64_t>(test::scaled(60), 6);
  for (std::int64_t round = 0; round < rounds; ++round) {
    Score score = silent_score();
    const std::uint64_t strings = 1 + random.below(1024);
    for (std::uint64_t i = strings; i > 7; --i) {
      score[0].item.mutable_scene_info()->mutable_scene()->add_strings()->set_name("C2");
    }
    const double within_ms = random.uniform(0.0, 200.0);
    for (int i = 0; i < 300; ++i) {
      const auto at = static_cast<std::int64_t>(random.uniform(0.0, within_ms) * 1e6);
      ScoreEntry entry = pluck(at, 0, random.uniform(), 0.5);
      v1::Tone& tone = *entry.item.mutable_tone();
      tone.set_string_index(static_cast<std::uint32_t>(random.below(strings)));
      tone.set_frequency_hz(static_cast<float>(std::exp(random.uniform(3.0, 8.0))));
      tone.set_decay_s(static_cast<float>(std::exp(random.uniform(-8.0, 1.0))));
      if (random.chance(0.2)) tone.set_glide_cents(static_cast<float>(random.uniform(0.0, 1200.0)));
      for (std::uint64_t n = random.below(4) * 16; n > 0; --n) {
        tone.add_partials(static_cast<float>(random.uniform(-1e3, 1e3)));
      }
      score.push_back(entry);
    }
    std::sort(score.begin() + 1, score.end(),
              [](const ScoreEntry& a, const ScoreEntry& b) { return a.t_ns < b.t_ns; });
    RenderReport report;
    const double gain = std::exp(random.uniform(-2.0, 4.6));  // --gain-db goes to 40
    const auto sound = rendered(score, round % 2 == 0 ? &shipped.files : nullptr, report, gain);
    CAPTURE(round);
    CHECK(all_good(sound));
    CHECK(report.played > 0);
    limited_s += report.limited_s;
  }
  CHECK(limited_s > 0.0);
}

TEST_CASE("a tone that gives no numbers is ended and counted, and what comes after it is whole") {
  const Sound sound = test::whole();
  const Strike good = design_string(test::tone_of(98.0), sound).value();
  const float not_a_number = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> samples(48000, 0.1F);
  std::vector<Strike> bad(7, good);
  bad[0].gain = kNan;
  bad[1].gain = kInfinity;
  bad[2].loop.loss_gain = 1.5;  // it swings itself up
  bad[3].loop.loss_pole = kNan;
  bad[4].excitation.amplitude[0] = std::numeric_limits<float>::infinity();
  bad[5].recorded = {samples.data(), 48000, 1.0};
  samples[700] = not_a_number;
  bad[6].recorded = {samples.data(), 48000, 1.0};
  bad[6].gain = 1e300;
  const auto whole = test::played(good, sound, 0.5);
  for (std::size_t i = 0; i < bad.size(); ++i) {
    CAPTURE(i);
    const auto synthesizer = std::make_unique<Synthesizer>(sound.body);
    bad[i].string = 1;
    bad[i].frames = 1'000'000;
    synthesizer->start(bad[i]);
    std::vector<float> frames(96000);
    synthesizer->render(frames);
    CHECK(all_good(frames));
    CHECK_EQ(synthesizer->broken(), 1);
    CHECK_EQ(synthesizer->sounding(), 0);
    // The gain of the limiter is whole again after a while.
    std::vector<float> rest(480000);
    synthesizer->render(rest);
    synthesizer->start(good);
    std::vector<float> after(whole.size());
    synthesizer->render(after);
    for (std::size_t k = 0; k < whole.size(); k += 13) {
      CHECK(static_cast<double>(after[k]) ==
            doctest::Approx(static_cast<double>(whole[k])).epsilon(1e-5).scale(1e-6));
    }
  }
}

TEST_CASE("below its threshold the limiter changes no bit, above it nothing passes 1") {
  Limiter limiter;
  test::SplitMix64 random(5);
  for (int i = 0; i < 10000; ++i) {
    const double in = random.uniform(-kLimiterThreshold, kLimiterThreshold);
    CHECK_EQ(limiter.next(in), static_cast<float>(in));
  }
  CHECK_EQ(limiter.limited(), 0);
  for (int i = 0; i < 10000; ++i) {
    const double in = random.uniform(-1.0, 1.0) * std::exp(random.uniform(-3.0, 13.0));
    const auto out = static_cast<double>(limiter.next(in));
    CHECK(std::abs(out) <= 1.0);
    CHECK(std::abs(out) <= std::abs(in) * (1.0 + 1e-7));
    CHECK(out * in >= 0.0);
  }
  for (const double in : {kNan, kInfinity, -kInfinity, 1e300, -1e300, kAbsurd}) {
    CHECK_EQ(limiter.next(in), 0.0F);
  }
  for (int i = 0; i < 400000; ++i) (void)limiter.next(0.1);
  CHECK_EQ(limiter.next(0.5), 0.5F);
  CHECK_EQ(limiter.next(-kLimiterThreshold), static_cast<float>(-kLimiterThreshold));
}

TEST_CASE("the limiter's knee is smooth and grows with what comes") {
  double before = 0.0;
  double slope_before = 1.0;
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 50000; ++i) {
    Limiter fresh;
    const double out = static_cast<double>(fresh.next(i * kStep));
    const double slope = (out - before) / kStep;
    if (i > 0) {
      // Steps of 6e-8 are the rounding to float.
      CHECK(slope >= -1e-3);
      CHECK(std::abs(slope - slope_before) < 5e-3);
      slope_before = slope;
    }
    before = out;
  }
  CHECK(before > 0.99);
}

TEST_CASE("a chord that is limited comes back to its own loudness") {
  Limiter limiter;
  const auto rms_of = [&](double amplitude, int frames) {
    double power = 0.0;
    for (int i = 0; i < frames; ++i) {
      const double out = static_cast<double>(limiter.next(amplitude * std::sin(0.0131 * i)));
      power += out * out / frames;
    }
    return std::sqrt(power);
  };
  CHECK(rms_of(3.0, 48000) < 0.75);
  CHECK(rms_of(0.3, 48000) > 0.8 * 0.3 / std::sqrt(2.0));
  CHECK(rms_of(0.3, 48000) == test::within(0.3 / std::sqrt(2.0), 1e-2));
}

}  // namespace hapticd::audio
