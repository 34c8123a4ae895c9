// Each partial of a string sounds as StringSounding tells it, whatever came before, came late or
// was lost. Truth: the wire's law of frequencies and decays, fitted to the sound by least squares;
// metres become loudness by what a Tone alone sounds like.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "clients/audio/render.h"
#include "clients/audio/sound_file.h"
#include "tests/clients/audio/partials_measure.h"
#include "tests/clients/audio/played.h"
#include "tests/clients/audio/temporary_folder.h"
#include "tests/clients/audio/tone_measure.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::audio {
namespace {

constexpr double kRate_hz = 48000.0;
constexpr double kSecond = 1e9;
constexpr std::size_t kCount = 12;
/// What is told is reached within this time, s.
constexpr double kReached_s = 0.01;

/// What a string sounds like from `at_s` on.
struct Told {
  double at_s = 0.0;
  double frequency_hz = 98.0;
  double inharmonicity = 0.0;
  std::array<double, kCount> partials_m{};
  std::array<double, kCount> decays_s{};
};

std::int64_t ns(double seconds) { return std::llround(seconds * kSecond); }

double energy_amplitude(const Told& told) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kCount; ++k) {
    sum += std::pow(static_cast<double>(k + 1) * told.partials_m[k], 2);
  }
  return std::sqrt(sum);
}

v1::Item tone_of(const Told& told) {
  v1::Item item;
  v1::Tone& tone = *item.mutable_tone();
  tone.set_t_ns(static_cast<std::uint64_t>(ns(told.at_s)));
  tone.set_frequency_hz(static_cast<float>(told.frequency_hz));
  tone.set_amplitude_m(static_cast<float>(energy_amplitude(told)));
  tone.set_level(static_cast<float>(std::min(1.0, energy_amplitude(told) / 5e-3)));
  tone.set_lambda(0.3F);
  tone.set_decay_s(static_cast<float>(told.decays_s[0]));
  const double largest = *std::max_element(told.partials_m.begin(), told.partials_m.end());
  for (const double partial : told.partials_m) {
    tone.add_partials(static_cast<float>(partial / largest));
  }
  return item;
}

v1::Item sounding_of(const Told& told, std::uint32_t number) {
  v1::Item item;
  v1::StringSounding& sounding = *item.mutable_string_sounding();
  sounding.set_t_ns(static_cast<std::uint64_t>(ns(told.at_s)));
  sounding.set_number(number);
  sounding.set_cause(number == 1 ? v1::SOUNDING_CAUSE_ONSET : v1::SOUNDING_CAUSE_TOUCH);
  sounding.set_lambda_to(1.0F);
  sounding.set_frequency_hz(static_cast<float>(told.frequency_hz));
  sounding.set_inharmonicity(static_cast<float>(told.inharmonicity));
  for (std::size_t k = 0; k < kCount; ++k) {
    sounding.add_partials_m(static_cast<float>(told.partials_m[k]));
    sounding.add_decays_s(static_cast<float>(told.decays_s[k]));
  }
  return item;
}

std::vector<float> rendered(const Score& score, double length_s, ToneFiles* tones = nullptr) {
  std::vector<float> sound;
  render(score, test::bare(), tones, [&](std::span<const float> frames) {
    sound.insert(sound.end(), frames.begin(), frames.end());
  });
  sound.resize(static_cast<std::size_t>(length_s * kRate_hz));
  return sound;
}

std::vector<test::Sine> sines_of(const Told& told) {
  std::vector<test::Sine> sines;
  for (std::size_t k = 0; k < kCount; ++k) {
    const double n = static_cast<double>(k + 1);
    const double b = told.inharmonicity;
    sines.push_back(
        {n * told.frequency_hz * std::sqrt((1.0 + b * n * n) / (1.0 + b)), told.decays_s[k]});
  }
  return sines;
}

/// Sound per metre of the fundamental, as a Tone alone has it.
double per_metre(const Told& told) {
  const auto alone = rendered({{0, tone_of(told)}}, 0.5);
  const double heard = std::abs(test::sine_in(alone, kRate_hz, told.frequency_hz, 0.1, 0.2));
  return heard * std::exp(0.2 / told.decays_s[0]) / told.partials_m[0];
}

double db(double a, double b) { return 20.0 * std::log10(a / b); }

/// Worst error of a partial that is heard, dB, and the loudest that is not to be, dB below the
/// loudest; from `since_s` after it was told.
struct Errors {
  double worst_db = 0.0;
  double stray_db = -200.0;
};

Errors errors_of(const std::vector<float>& sound, const Told& told, double scale, double since_s) {
  const double length_s = 8.0 / told.frequency_hz;
  const auto heard =
      test::amplitudes_in(sound, kRate_hz, sines_of(told), told.at_s + since_s, length_s);
  std::array<double, kCount> due{};
  for (std::size_t k = 0; k < kCount; ++k) {
    due[k] = scale * static_cast<double>(k + 1) * told.partials_m[k] *
             std::exp(-since_s / told.decays_s[k]);
  }
  const double loudest = *std::max_element(due.begin(), due.end());
  Errors errors;
  for (std::size_t k = 0; k < kCount; ++k) {
    if (due[k] > 3e-3 * loudest) {
      errors.worst_db = std::max(errors.worst_db, std::abs(db(heard[k], due[k])));
    } else {
      errors.stray_db = std::max(errors.stray_db, db(heard[k], loudest));
    }
  }
  return errors;
}

/// Of all kinds: some partials are silent, others are 40 dB softer than the loudest.
Told drawn(test::SplitMix64& random, double frequency_hz) {
  Told told;
  told.frequency_hz = frequency_hz;
  told.inharmonicity = random.chance(0.5) ? random.uniform(0.0, 1e-4) : 0.0;
  const double size = 1e-3 * std::pow(10.0, random.uniform(-1.5, 0.3));
  for (std::size_t k = 0; k < kCount; ++k) {
    const double n = static_cast<double>(k + 1);
    told.decays_s[k] = std::pow(10.0, random.uniform(-1.2, 0.3));
    if (k > 0 && random.chance(0.3)) continue;
    told.partials_m[k] = size / n * std::pow(10.0, random.uniform(-2.0, 0.0));
  }
  return told;
}

/// As a pluck leaves it: the fundamental is loud.
Told plucked(test::SplitMix64& random, double frequency_hz) {
  Told told = drawn(random, frequency_hz);
  told.partials_m[0] = random.uniform(1e-3, 3e-3);
  told.decays_s.fill(random.uniform(0.5, 1.5));
  return told;
}

/// A finger at 1/3 of a string has left every third partial.
Told harmonic_of(const Told& open) {
  Told told = open;
  for (std::size_t k = 0; k < kCount; ++k) told.partials_m[k] *= (k + 1) % 3 == 0 ? 0.7 : 1e-3;
  return told;
}

/// As a pluck near an end.
Told open_string() {
  Told told;
  told.decays_s.fill(1.0);
  for (std::size_t k = 0; k < kCount; ++k) {
    const double n = static_cast<double>(k + 1);
    told.partials_m[k] = 2e-3 * std::abs(std::sin(0.13 * n * std::numbers::pi)) / n / n / 0.4;
  }
  return told;
}

}  // namespace

TEST_CASE("every partial has the amplitude that was told last 10 ms later, and its decay on") {
  test::SplitMix64 random(81);
  const std::int64_t runs = std::max<std::int64_t>(test::scaled(200), 12);
  for (std::int64_t run = 0; run < runs; ++run) {
    const double hz = random.uniform(65.0, 330.0);
    const Told tone = plucked(random, hz);
    Score score{{0, tone_of(tone)}};
    Told last;
    const auto messages = static_cast<std::uint32_t>(1 + random.below(6));
    double at_s = 0.0;
    for (std::uint32_t number = 1; number <= messages; ++number) {
      at_s += random.uniform(0.004, 0.08);
      last = drawn(random, hz * std::exp2(random.uniform(-0.5, 1.5)));
      last.at_s = at_s;
      score.push_back({ns(at_s), sounding_of(last, number)});
    }
    CAPTURE(run);
    CAPTURE(last.frequency_hz);
    const auto sound = rendered(score, at_s + 1.0);
    const double scale = per_metre(tone);
    for (const double since_s : {kReached_s, 0.15}) {
      CAPTURE(since_s);
      const Errors errors = errors_of(sound, last, scale, since_s);
      CHECK(errors.worst_db < 0.5);
      CHECK(errors.stray_db < -45.0);
    }
  }
}

TEST_CASE("a string touched at a third and left alone sounds as its harmonic") {
  const Told open = open_string();
  Told first = open;
  first.at_s = 1e-3;
  Told told = harmonic_of(open);
  told.at_s = 0.2;
  const auto sound = rendered(
      {{ns(1e-3), sounding_of(first, 1)}, {0, tone_of(open)}, {ns(0.2), sounding_of(told, 2)}},
      1.0);
  const Errors errors = errors_of(sound, told, per_metre(open), 0.02);
  CHECK(errors.worst_db < 0.5);
  CHECK(errors.stray_db < -45.0);
}

TEST_CASE(
    "a finger that makes a string softer by 24 dB at once is heard to, after whatever onset") {
  const Told open = open_string();
  Told soft = open;
  soft.at_s = 0.3;
  for (double& partial : soft.partials_m) partial *= std::pow(10.0, -24.0 / 20.0) * std::exp(-0.3);
  Told onset = open;
  onset.at_s = 1.5e-3;
  const Score orders[] = {
      {{ns(1.5e-3), sounding_of(onset, 1)}, {0, tone_of(open)}, {ns(0.3), sounding_of(soft, 2)}},
      {{0, tone_of(open)}, {ns(1.5e-3), sounding_of(onset, 1)}, {ns(0.3), sounding_of(soft, 2)}},
      {{0, tone_of(open)}, {ns(0.3), sounding_of(soft, 2)}}};
  for (const Score& score : orders) {
    const auto sound = rendered(score, 1.0);
    const auto level_at = [&](double t) {
      return std::abs(test::sine_in(sound, kRate_hz, 98.0, t, 0.1));
    };
    // Both windows are 0.2 s apart, in which the string itself loses e^-0.2.
    CHECK(db(level_at(0.32), level_at(0.12)) == test::within(-24.0 - 0.2 * 8.686, 0.02));
  }
}

TEST_CASE("in whatever order Tone and Soundings come, and whichever are lost, the next is right") {
  test::SplitMix64 random(82);
  const std::int64_t runs = std::max<std::int64_t>(test::scaled(200), 12);
  for (std::int64_t run = 0; run < runs; ++run) {
    const double hz = random.uniform(65.0, 330.0);
    const Told tone = plucked(random, hz);
    std::vector<v1::Item> items{tone_of(tone)};
    Told onset = tone;
    onset.at_s = random.uniform(0.0, 3e-3);
    items.push_back(sounding_of(onset, 1));
    const auto count = static_cast<std::uint32_t>(random.below(5));
    for (std::uint32_t k = 0; k < count; ++k) {
      Told told = drawn(random, hz * std::exp2(random.uniform(-0.5, 1.5)));
      told.at_s = 0.02 + 0.02 * k;
      items.push_back(sounding_of(told, 2 + k));
      // Silence in between is no end.
      if (random.chance(0.1)) {
        items.back().mutable_string_sounding()->clear_partials_m();
        items.back().mutable_string_sounding()->clear_decays_s();
      }
    }
    for (std::size_t k = items.size() - 1; k > 0; --k) {
      std::swap(items[k], items[random.below(k + 1)]);
    }
    Score score;
    double at_s = 0.0;
    for (const v1::Item& item : items) {
      if (!item.has_tone() && random.chance(0.4)) continue;
      const bool at_once = random.chance(0.5);
      if (!at_once) at_s += random.uniform(0.0, 0.03);
      score.push_back({ns(at_s), item});
    }
    Told last = drawn(random, hz);
    // A Tone has choked by then what sounded before it.
    last.at_s = at_s + random.uniform(0.04, 0.1);
    score.push_back({ns(last.at_s), sounding_of(last, 9)});
    CAPTURE(run);
    const auto sound = rendered(score, last.at_s + 0.6);
    const Errors errors = errors_of(sound, last, per_metre(tone), kReached_s);
    CHECK(errors.worst_db < 0.5);
    CHECK(errors.stray_db < -45.0);
  }
}

TEST_CASE("a Tone that comes after what it led to is at once what it led to") {
  const Told open = open_string();
  Told told = harmonic_of(open);
  told.at_s = 0.1;
  const auto sound = rendered({{ns(0.1), sounding_of(told, 3)}, {ns(0.2), tone_of(open)}}, 1.0);
  const Errors errors = errors_of(sound, told, per_metre(open), 0.1 + 0.03);
  CHECK(errors.worst_db < 0.5);
  CHECK(errors.stray_db < -45.0);
}

TEST_CASE("partials that leap every 10 ms make no clicks: nothing sounds where the string cannot") {
  test::SplitMix64 random(83);
  const Told tone = plucked(random, 98.0);
  Score score{{0, tone_of(tone)}};
  std::uint32_t number = 0;
  for (double t = 0.01; t < 0.8; t += 0.01) {
    Told told = tone;
    told.at_s = t;
    for (double& partial : told.partials_m) partial *= std::pow(10.0, random.uniform(-1.5, 0.0));
    score.push_back({ns(t), sounding_of(told, ++number)});
  }
  const auto sound = rendered(score, 1.0);
  const double loudest = std::abs(test::sine_in(sound, kRate_hz, 98.0, 0.2, 0.5));
  REQUIRE(loudest > 1e-4);
  for (double hz = 5000.0; hz < 20000.0; hz += 171.0) {
    CAPTURE(hz);
    CHECK(std::abs(test::sine_in(sound, kRate_hz, hz, 0.2, 0.5)) < 1e-5 * loudest);
  }
}

TEST_CASE("partials go on where they are when new amplitudes are told: their phases do not leap") {
  const Told open = open_string();
  Told told = harmonic_of(open);
  told.at_s = 0.2;
  told.partials_m[0] = open.partials_m[0] * 0.5;
  const auto sound = rendered({{0, tone_of(open)}, {ns(0.2), sounding_of(told, 1)}}, 1.0);
  for (const double hz : {98.0, 294.0, 588.0}) {
    const auto before = test::sine_in(sound, kRate_hz, hz, 0.1, 0.09);
    const auto after = test::sine_in(sound, kRate_hz, hz, 0.22, 0.09);
    CAPTURE(hz);
    // The law of a Tone has a B of its own, 3e-5: up to 0.1 s of a thousandth of the pitch.
    CHECK(std::abs(std::arg(after / before)) < 0.5);
  }
}

TEST_CASE("a recording becomes softer as told, and gives way where other partials sound") {
  const test::TemporaryFolder folder;
  const Told open = open_string();
  {
    const auto alone = rendered({{0, tone_of(open)}}, 2.0);
    SoundFile file(folder.path() / "g.wav", kRate_hz, 98.0);
    file.write(alone);
  }
  ToneFiles tones(folder.path(), kRate_hz);
  ScoreEntry scene{0, {}};
  scene.item.mutable_scene_info()->mutable_scene()->add_strings()->set_name("g");
  Told onset = open;
  onset.at_s = 1e-3;
  Told soft = open;
  soft.at_s = 0.3;
  for (double& partial : soft.partials_m) partial *= std::pow(10.0, -24.0 / 20.0) * std::exp(-0.3);
  Told harmonic = harmonic_of(soft);
  harmonic.at_s = 0.7;
  const Score score{scene,
                    {ns(1e-3), sounding_of(onset, 1)},
                    {0, tone_of(open)},
                    {ns(0.3), sounding_of(soft, 2)},
                    {ns(0.7), sounding_of(harmonic, 3)}};
  const auto sound = rendered(score, 1.5, &tones);
  const auto level_at = [&](double t) {
    return std::abs(test::sine_in(sound, kRate_hz, 98.0, t, 0.1));
  };
  REQUIRE(level_at(0.12) > 1e-4);
  CHECK(db(level_at(0.32), level_at(0.12)) == test::within(-24.0 - 0.2 * 8.686, 0.03));
  const Errors errors = errors_of(sound, harmonic, per_metre(open), 0.04);
  CHECK(errors.worst_db < 1.0);
  CHECK(errors.stray_db < -35.0);
}

}  // namespace hapticd::audio
