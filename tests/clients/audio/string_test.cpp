// The computed string against what a string is: its pitch, the law of a stiff string, the decay of
// its partials, the comb of the place it is plucked at, the glide. Measured on the sound alone.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "clients/audio/score.h"
#include "clients/audio/string_design.h"
#include "tests/clients/audio/played.h"
#include "tests/clients/audio/tone_measure.h"
#include "tests/support/within.h"

namespace hapticd::audio {
namespace {

using test::bare;
using test::cents;
using test::decay_near;
using test::frequency_near;
using test::played;
using test::sine_in;
using test::tone_of;
using test::whole;

constexpr double kRate_hz = 48000.0;

/// Amplitude of partial n when the string was let go, the decay since then undone.
double partial_at_onset(const std::vector<float>& sound, double frequency_hz) {
  constexpr double kLength_s = 0.25;
  const double early = std::abs(sine_in(sound, kRate_hz, frequency_hz, 0.05, kLength_s));
  const double decay_s = decay_near(sound, kRate_hz, frequency_hz, 0.05, kLength_s, 0.1);
  // A Hann window sees a decaying sine as it is in the window's middle, but for 1 %.
  return early * std::exp((0.05 + 0.5 * kLength_s) / decay_s);
}

}  // namespace

TEST_CASE("all seven strings sound their pitch within a hundredth of a cent at every sample rate") {
  for (const double rate_hz : {44100.0, 48000.0, 96000.0, 192000.0}) {
    for (const OpenString& open : kZhengDiao) {
      const auto sound = played(tone_of(open.frequency_hz), whole(rate_hz), 1.4);
      const double measured =
          frequency_near(sound, rate_hz, open.frequency_hz * 1.002, 0.3, 0.5, 0.5);
      CAPTURE(rate_hz);
      CAPTURE(open.name);
      CHECK(std::abs(cents(measured, open.frequency_hz)) < 0.01);
    }
  }
}

TEST_CASE("partials lie where the law of a stiff string puts them, to 4 cents") {
  for (const OpenString& open : kZhengDiao) {
    ToneSound tone = tone_of(open.frequency_hz);
    for (const double b : {0.0, 3e-5, 1e-4}) {
      tone.inharmonicity = b;
      const auto sound = played(tone, bare(), 0.6);
      for (int n = 2; n * open.frequency_hz < 1500.0; ++n) {
        if (std::abs(std::sin(n * std::numbers::pi * tone.lambda)) < 0.2) continue;
        const double law = n * open.frequency_hz * std::sqrt((1.0 + b * n * n) / (1.0 + b));
        const double measured = frequency_near(sound, kRate_hz, law, 0.1, 0.25, 0.1);
        CAPTURE(open.name);
        CAPTURE(n);
        CHECK(std::abs(cents(measured, law)) < 4.0);
      }
    }
  }
}

TEST_CASE(
    "the fundamental decays as the event says, high partials six times as fast, none slower") {
  for (const OpenString& open : kZhengDiao) {
    for (const double decay_s : {0.2, 0.5, 3.0}) {
      ToneSound tone = tone_of(open.frequency_hz);
      tone.decay_s = decay_s;
      tone.inharmonicity = 0.0;
      tone.lambda = 0.05;
      const auto sound = played(tone, bare(), 1.5);
      const double f1 = open.frequency_hz;
      CAPTURE(open.name);
      CAPTURE(decay_s);
      CHECK(decay_near(sound, kRate_hz, f1, 0.1, 0.25, 0.3) == test::within(decay_s, 2e-3));
      double before = decay_s * 1.002;
      for (int n = 2; n * f1 < 2500.0; n *= 2) {
        const double here = decay_near(sound, kRate_hz, n * f1, 0.05, 0.15, 0.05);
        CHECK(here < before);
        before = here;
      }
      const int high = static_cast<int>(std::lround(kHighFrequency_hz / f1));
      const double expected = decay_s / kHighDecayRatio;
      const double here = decay_near(sound, kRate_hz, high * f1, 0.02, 0.1, 0.05);
      CHECK(here == test::within(expected, 0.06));
    }
  }
}

TEST_CASE(
    "a string plucked at a quarter lacks every fourth partial, the others follow sin(n pi lambda) "
    "/ n") {
  ToneSound tone = tone_of(98.0);
  tone.lambda = 0.25;
  tone.inharmonicity = 0.0;
  const auto sound = played(tone, bare(), 1.0);
  const double first = partial_at_onset(sound, 98.0);
  for (int n = 2; n <= 10; ++n) {
    CAPTURE(n);
    const double law =
        std::abs(std::sin(n * std::numbers::pi * 0.25)) / n / std::sin(std::numbers::pi * 0.25);
    const double blunt = n * std::numbers::pi * kFingerWidth;
    if (n % 4 == 0) {
      CHECK(std::abs(sine_in(sound, kRate_hz, n * 98.0, 0.05, 0.25)) < 4e-3 * first);
    } else {
      CHECK(partial_at_onset(sound, n * 98.0) / first ==
            test::within(law * std::exp(-0.5 * blunt * blunt), 0.03));
    }
  }
}

TEST_CASE("partials that the event names are those that sound, as forces at the bridge") {
  const std::array<float, 5> partials{1.0F, 0.0F, 0.5F, 0.0F, 0.2F};
  ToneSound tone = tone_of(110.0);
  tone.partials = partials;
  tone.inharmonicity = 0.0;
  const auto sound = played(tone, bare(), 1.0);
  const double first = partial_at_onset(sound, 110.0);
  CHECK(partial_at_onset(sound, 330.0) / first == test::within(1.5, 0.03));
  CHECK(partial_at_onset(sound, 550.0) / first == test::within(1.0, 0.03));
  CHECK(std::abs(sine_in(sound, kRate_hz, 220.0, 0.05, 0.25)) < 4e-3 * first);
}

TEST_CASE("a glide begins where the event says and ends at the pitch, on the way by its law") {
  for (const OpenString& open : kZhengDiao) {
    ToneSound tone = tone_of(open.frequency_hz);
    tone.glide_cents = 79.0;
    tone.glide_decay_s = 0.5;
    const auto sound = played(tone, bare(), 4.5);
    for (const double middle_s : {0.3, 0.5, 1.0}) {
      // The mean over the short window and between the two, of a law that is nearly straight there.
      const double law_cents = 79.0 * std::exp(-middle_s / 0.5);
      const double guess = open.frequency_hz * std::exp2(law_cents / 1200.0);
      const double measured = frequency_near(sound, kRate_hz, guess, middle_s - 0.11, 0.2, 0.02);
      CAPTURE(open.name);
      CAPTURE(middle_s);
      CHECK(std::abs(cents(measured, guess)) < 1.0);
    }
    const double end = frequency_near(sound, kRate_hz, open.frequency_hz, 3.6, 0.3, 0.3);
    CHECK(std::abs(cents(end, open.frequency_hz)) < 0.1);
  }
}

TEST_CASE("loudness follows the level alone: equal for every string, place and decay within 3 %") {
  for (const OpenString& open : kZhengDiao) {
    for (const double lambda : {0.02, 0.1, 0.5}) {
      for (const double decay_s : {0.3, 0.5, 2.0}) {
        ToneSound tone = tone_of(open.frequency_hz);
        tone.lambda = lambda;
        tone.decay_s = decay_s;
        const auto sound = played(tone, whole(), 0.5);
        CAPTURE(open.name);
        CAPTURE(lambda);
        CAPTURE(decay_s);
        CHECK(test::rms(sound, kRate_hz, 0.0, kLevelWindow_s) ==
              test::within(0.5 * kLevelRms, 0.03));
      }
    }
  }
}

TEST_CASE("twice the level is twice every sample, and no level is silence") {
  ToneSound tone = tone_of(87.3);
  tone.level = 0.25;
  const auto soft = played(tone, bare(), 0.3);
  tone.level = 0.5;
  const auto loud = played(tone, bare(), 0.3);
  for (std::size_t i = 0; i < soft.size(); ++i) CHECK_EQ(loud[i], 2.0F * soft[i]);
  tone.level = 0.0;
  const auto silent = played(tone, bare(), 0.3);
  CHECK(std::all_of(silent.begin(), silent.end(), [](float frame) { return frame == 0.0F; }));
}

TEST_CASE("seven strings of full level at once stay below full scale") {
  std::vector<double> sum(48000);
  for (const OpenString& open : kZhengDiao) {
    ToneSound tone = tone_of(open.frequency_hz);
    tone.level = 1.0;
    tone.lambda = 0.1;
    const auto sound = played(tone, whole(), 1.0);
    // At different instants, as fingers do.
    const auto shift = static_cast<std::size_t>(std::lround((open.frequency_hz - 65.0) * 8.0));
    for (std::size_t i = shift; i < sum.size(); ++i)
      sum[i] += static_cast<double>(sound[i - shift]);
  }
  const double most = std::abs(*std::max_element(
      sum.begin(), sum.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
  MESSAGE("peak of seven strings: " << most);
  CHECK(most < 1.0);
}

TEST_CASE("what cannot be a tone, or does not fit into the string, is refused") {
  const auto refused = [](auto change, double rate_hz) {
    ToneSound tone = tone_of(98.0);
    change(tone);
    return !design_string(tone, bare(rate_hz));
  };
  const double nan = std::nan("");
  CHECK(refused([](ToneSound& tone) { tone.frequency_hz = 0.0; }, kRate_hz));
  CHECK(refused([=](ToneSound& tone) { tone.frequency_hz = nan; }, kRate_hz));
  CHECK(refused([](ToneSound& tone) { tone.frequency_hz = 2e4; }, kRate_hz));
  CHECK(refused([](ToneSound& tone) { tone.frequency_hz = 5.9; }, kRate_hz));
  CHECK(refused([](ToneSound& tone) { tone.frequency_hz = 23.0; }, 192000.0));
  CHECK(refused([=](ToneSound& tone) { tone.level = nan; }, kRate_hz));
  CHECK(refused([](ToneSound& tone) { tone.level = 1.1; }, kRate_hz));
  CHECK(refused([](ToneSound& tone) { tone.decay_s = 0.0; }, kRate_hz));
  CHECK(refused([=](ToneSound& tone) { tone.lambda = nan; }, kRate_hz));
  CHECK(refused([](ToneSound& tone) { tone.glide_cents = 1300.0; }, kRate_hz));
  CHECK(refused([=](ToneSound& tone) { tone.inharmonicity = nan; }, kRate_hz));
  CHECK_FALSE(refused([](ToneSound&) {}, kRate_hz));
}

TEST_CASE("every tone within the ranges is finite and dies away") {
  for (const double frequency_hz : {6.1, 20.0, 440.0, 2000.0, 4000.0}) {
    for (const double decay_s : {1e-3, 0.05, 0.5, 1000.0}) {
      for (const double b : {0.0, 1e-4, 0.1}) {
        for (const double glide : {0.0, 1200.0}) {
          ToneSound tone = tone_of(frequency_hz);
          tone.decay_s = decay_s;
          tone.inharmonicity = b;
          tone.glide_cents = glide;
          tone.glide_decay_s = 0.1;
          const auto strike = design_string(tone, whole());
          if (!strike) continue;
          const auto sound = played(*strike, whole(), 1.0);
          const bool bounded = std::all_of(sound.begin(), sound.end(),
                                           [](float frame) { return std::abs(frame) < 20.0F; });
          CAPTURE(frequency_hz);
          CAPTURE(decay_s);
          CAPTURE(b);
          CAPTURE(glide);
          CHECK(bounded);
        }
      }
    }
  }
}

}  // namespace hapticd::audio
