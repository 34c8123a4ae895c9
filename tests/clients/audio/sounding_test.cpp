// What becomes of a string that sounds, as StringSounding tells it: pitch, loudness and damping of
// the sound, measured in it.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "clients/audio/render.h"
#include "tests/clients/audio/played.h"
#include "tests/clients/audio/tone_measure.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::audio {
namespace {

constexpr double kRate_hz = 48000.0;
constexpr double kSecond = 1e9;

/// A course that a string takes after it was plucked at 0.
struct Course {
  double tone_hz = 98.0;
  std::function<double(double)> cents;  ///< above tone_hz, at t
  std::function<double(double)> level;  ///< amplitude over the one of the tone, at t
  double length_s = 1.0;
  std::vector<double> partials{1.0};
};

v1::Item tone_of(const Course& course) {
  v1::Item item;
  v1::Tone& tone = *item.mutable_tone();
  tone.set_frequency_hz(static_cast<float>(course.tone_hz));
  tone.set_level(0.3F);
  tone.set_lambda(0.3F);
  tone.set_decay_s(1.0F);
  for (const double partial : course.partials) tone.add_partials(static_cast<float>(partial));
  return item;
}

v1::Item sounding_at(const Course& course, double t_s, std::uint32_t number) {
  v1::Item item;
  v1::StringSounding& sounding = *item.mutable_string_sounding();
  sounding.set_t_ns(static_cast<std::uint64_t>(t_s * kSecond));
  sounding.set_number(number);
  sounding.set_frequency_hz(
      static_cast<float>(course.tone_hz * std::exp2(course.cents(t_s) / 1200.0)));
  sounding.set_cents_per_s(
      static_cast<float>((course.cents(t_s + 1e-3) - course.cents(t_s - 1e-3)) / 2e-3));
  const double decay_s = 2e-3 / std::log(course.level(t_s - 1e-3) / course.level(t_s + 1e-3));
  for (const double partial : course.partials) {
    sounding.add_partials_m(static_cast<float>(1e-3 * partial * course.level(t_s)));
    sounding.add_decays_s(static_cast<float>(std::min(decay_s, 1000.0)));
  }
  return item;
}

/// Told every `pause_s` from 5 ms on.
std::vector<float> rendered(const Course& course, double pause_s) {
  Score score{{0, tone_of(course)}};
  std::uint32_t number = 7;
  for (double t = 5e-3; t < course.length_s; t += pause_s) {
    score.push_back({static_cast<std::int64_t>(t * kSecond), sounding_at(course, t, ++number)});
  }
  std::vector<float> sound;
  render(score, test::bare(), nullptr, [&](std::span<const float> frames) {
    sound.insert(sound.end(), frames.begin(), frames.end());
  });
  return sound;
}

double freely(double t) { return std::exp(-t); }

/// Cents above the tone in 30 ms about t.
double measured_cents(const std::vector<float>& sound, const Course& course, double t) {
  const double guess = course.tone_hz * std::exp2(course.cents(t) / 1200.0);
  const double length = 0.05;
  const double apart = 0.01;
  const double hz =
      test::frequency_near(sound, kRate_hz, guess, t - 0.5 * (length + apart), length, apart);
  return test::cents(hz, course.tone_hz);
}

}  // namespace

TEST_CASE("the sound of a glide and of a vibrato is within 5 cents of what the string does") {
  test::SplitMix64 random(71);
  const std::int64_t runs = std::max<std::int64_t>(test::scaled(60), 6);
  for (std::int64_t run = 0; run < runs; ++run) {
    Course course;
    course.level = freely;
    course.tone_hz = random.uniform(130.0, 400.0);
    const double size = random.uniform(-900.0, 900.0);
    const double shake = random.uniform(3.0, 7.0);
    const bool glides = random.chance(0.5);
    // As fast as the issue of the wave's dead reckoning is: 2000 cents/s, or 60 cents of vibrato.
    course.cents = [=](double t) {
      if (!glides) return 30.0 * std::sin(2.0 * std::numbers::pi * shake * t);
      const double share = std::clamp((t - 0.1) / 0.6, 0.0, 1.0);
      return size * share * share * (3.0 - 2.0 * share);
    };
    CAPTURE(course.tone_hz);
    CAPTURE(size);
    CAPTURE(shake);
    CAPTURE(glides);
    const auto sound = rendered(course, 0.01);
    for (double t = 0.08; t < 0.85; t += 0.013) {
      CHECK(std::abs(measured_cents(sound, course, t) - course.cents(t)) < 5.0);
    }
  }
}

TEST_CASE("a string that is stopped after its pluck sounds at the pitch of the stop, and back") {
  for (const double cents : {-1100.0, -300.0, 80.0, 702.0, 1900.0}) {
    CAPTURE(cents);
    Course course;
    course.tone_hz = 130.8;
    course.level = freely;
    course.cents = [=](double t) { return t > 0.3 && t < 0.6 ? cents : 0.0; };
    Score score{{0, tone_of(course)}};
    for (const double t : {0.01, 0.302, 0.602}) {
      v1::Item item = sounding_at(course, t, static_cast<std::uint32_t>(1000.0 * t));
      item.mutable_string_sounding()->set_cents_per_s(0.0F);
      score.push_back({static_cast<std::int64_t>(t * kSecond), item});
    }
    std::vector<float> sound;
    render(score, test::bare(), nullptr, [&](std::span<const float> frames) {
      sound.insert(sound.end(), frames.begin(), frames.end());
    });
    for (const double t : {0.2, 0.45, 0.8}) {
      CHECK(std::abs(measured_cents(sound, course, t) - course.cents(t)) < 5.0);
    }
  }
}

TEST_CASE("a bent pitch makes no noise: no frame steps, and no line where the string has none") {
  Course course;
  course.tone_hz = 196.0;
  course.level = freely;
  course.cents = [](double t) { return 25.0 * std::sin(2.0 * std::numbers::pi * 5.0 * t); };
  const auto sound = rendered(course, 0.01);
  const double loudest = std::abs(test::sine_in(sound, kRate_hz, 196.0, 0.2, 0.5));
  REQUIRE(loudest > 1e-3);
  for (double hz = 700.0; hz < 20000.0; hz += 171.0) {
    CAPTURE(hz);
    CHECK(std::abs(test::sine_in(sound, kRate_hz, hz, 0.2, 0.5)) < 1e-3 * loudest);
  }
}

TEST_CASE("a finger that damps is heard as fast as it does, and a string grown louder as loud") {
  Course course;
  course.cents = [](double) { return 0.0; };
  course.level = [](double t) {
    return t < 0.3 ? std::exp(-t) : std::exp(-0.3) * std::exp(-(t - 0.3) / 0.08);
  };
  const auto damped = rendered(course, 0.02);
  const auto level_at = [&](const std::vector<float>& sound, double t) {
    return std::abs(test::sine_in(sound, kRate_hz, course.tone_hz, t - 0.02, 0.04));
  };
  const double began = level_at(damped, 0.1) / course.level(0.1);
  for (const double t : {0.2, 0.28, 0.36, 0.42, 0.5}) {
    CAPTURE(t);
    CHECK(20.0 * std::abs(std::log10(level_at(damped, t) / (began * course.level(t - 5e-3)))) <
          1.0);
  }
  course.level = [](double t) { return t < 0.3 ? std::exp(-t) : 1.6 * std::exp(-t); };
  const auto louder = rendered(course, 0.02);
  CHECK(level_at(louder, 0.6) / level_at(louder, 0.2) ==
        test::within(course.level(0.6) / course.level(0.2), 0.1));
}

TEST_CASE("older messages and such as no string can send change nothing") {
  Course course;
  course.level = freely;
  course.cents = [](double) { return 0.0; };
  const auto sound_of = [&](const std::function<void(v1::StringSounding&)>& spoil) {
    Score score{{0, tone_of(course)}};
    score.push_back({5'000'000, sounding_at(course, 5e-3, 9)});
    v1::Item item = sounding_at(course, 0.1, 10);
    spoil(*item.mutable_string_sounding());
    if (item.string_sounding().number() != 0) score.push_back({100'000'000, item});
    std::vector<float> sound;
    render(score, test::bare(), nullptr, [&](std::span<const float> frames) {
      sound.insert(sound.end(), frames.begin(), frames.end());
    });
    // A file goes on as long as anything that came may sound.
    sound.resize(static_cast<std::size_t>(kRate_hz));
    return sound;
  };
  const auto without = sound_of([](v1::StringSounding& sounding) { sounding.set_number(0); });
  const auto same = [&](const std::function<void(v1::StringSounding&)>& spoil) {
    return sound_of(spoil) == without;
  };
  CHECK(same([](v1::StringSounding& sounding) {
    sounding.set_number(8);
    sounding.set_frequency_hz(300.0F);
  }));
  const float nan = std::nanf("");
  for (const float number : {nan, -1.0F, 0.0F, 1e30F}) {
    CAPTURE(number);
    CHECK(same([&](v1::StringSounding& sounding) { sounding.set_frequency_hz(number); }));
    CHECK(same([&](v1::StringSounding& sounding) { sounding.set_partials_m(0, number); }));
    if (number != 1e30F) {
      CHECK(same([&](v1::StringSounding& sounding) { sounding.set_decays_s(0, number); }));
    }
    if (number != 0.0F && number != -1.0F) {
      CHECK(same([&](v1::StringSounding& sounding) { sounding.set_cents_per_s(number); }));
    }
  }
  CHECK(same([](v1::StringSounding& sounding) { sounding.clear_decays_s(); }));
}

TEST_CASE("a string that nobody has released is heard once it is told to sound, and falls silent") {
  Course course;
  course.level = freely;
  course.cents = [](double) { return 0.0; };
  course.tone_hz = 146.8;
  Score score{{0, sounding_at(course, 0.0, 1)}};
  v1::Item silent;
  silent.mutable_string_sounding()->set_number(2);
  silent.mutable_string_sounding()->set_t_ns(500'000'000);
  score.push_back({500'000'000, silent});
  std::vector<float> sound;
  render(score, test::bare(), nullptr, [&](std::span<const float> frames) {
    sound.insert(sound.end(), frames.begin(), frames.end());
  });
  CHECK(std::abs(test::cents(test::frequency_near(sound, kRate_hz, 146.8, 0.1, 0.2, 0.1), 146.8)) <
        2.0);
  CHECK(test::rms(sound, kRate_hz, 0.8, 0.1) < 1e-3 * test::rms(sound, kRate_hz, 0.3, 0.1));
}

}  // namespace hapticd::audio
