// Sound at another sample rate, against closed forms: a sine is a sine of the same pitch, phase and
// amplitude, and what the other rate cannot hold is gone.
#include "clients/audio/resampling.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/clients/audio/tone_measure.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::audio {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

std::vector<float> sine(double frequency_hz, int rate_hz, double length_s) {
  std::vector<float> samples(static_cast<std::size_t>(length_s * rate_hz));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] =
        static_cast<float>(0.5 * std::sin(kTurn * frequency_hz * static_cast<double>(i) / rate_hz));
  }
  return samples;
}

/// Power of what `samples` differ by from a sine of amplitude `amplitude`, over that of a sine of
/// 0.5, dB; the middle half of them.
double error_db(const std::vector<float>& samples, double frequency_hz, int rate_hz,
                double amplitude) {
  double power = 0.0;
  const std::size_t first = samples.size() / 4;
  const std::size_t last = 3 * samples.size() / 4;
  for (std::size_t i = first; i < last; ++i) {
    const double truth =
        amplitude * std::sin(kTurn * frequency_hz * static_cast<double>(i) / rate_hz);
    power += std::pow(static_cast<double>(samples[i]) - truth, 2.0);
  }
  return 10.0 * std::log10(power / static_cast<double>(last - first) / 0.125 + 1e-30);
}

struct Rates {
  int from_hz;
  int to_hz;
};

/// Usual pairs, and random ones.
std::vector<Rates> pairs() {
  std::vector<Rates> found{{44100, 48000}, {48000, 44100},  {96000, 48000},
                           {22050, 48000}, {192000, 44100}, {8000, 192000}};
  test::SplitMix64 random(441);
  for (std::int64_t i = 0; i < test::scaled(40); ++i) {
    found.push_back({8000 + static_cast<int>(random.below(184001)),
                     8000 + static_cast<int>(random.below(184001))});
  }
  return found;
}

}  // namespace

TEST_CASE("up to 0.9 of the lower Nyquist frequency a sine stays itself within -100 dB") {
  test::SplitMix64 random(9);
  for (const Rates& rates : pairs()) {
    const int from_hz = rates.from_hz;
    const int to_hz = rates.to_hz;
    const double nyquist_hz = 0.5 * std::min(from_hz, to_hz);
    for (const double share : {0.01, 0.5, 0.9, random.uniform(0.01, 0.9)}) {
      CAPTURE(from_hz);
      CAPTURE(to_hz);
      CAPTURE(share);
      const auto out = resampled(sine(share * nyquist_hz, from_hz, 0.1), from_hz, to_hz);
      CHECK(error_db(out, share * nyquist_hz, to_hz, 0.5) < -100.0);
    }
  }
}

TEST_CASE("what the other rate cannot hold is below -100 dB, and is no other pitch") {
  test::SplitMix64 random(10);
  for (const Rates& rates : pairs()) {
    const int from_hz = rates.from_hz;
    const int to_hz = rates.to_hz;
    if (to_hz >= from_hz) continue;
    const double ratio = static_cast<double>(from_hz) / to_hz;
    for (const double share : {1.0, random.uniform(1.0, ratio), 0.999 * ratio}) {
      CAPTURE(from_hz);
      CAPTURE(to_hz);
      CAPTURE(share);
      const auto out = resampled(sine(0.5 * share * to_hz, from_hz, 0.1), from_hz, to_hz);
      CHECK(error_db(out, 0.0, to_hz, 0.0) < -100.0);
    }
  }
}

TEST_CASE("the pitch stays within a thousandth of a cent over seconds") {
  for (const Rates& rates : {Rates{44100, 48000}, Rates{48000, 44100}, Rates{44101, 48000}}) {
    const auto out = resampled(sine(98.0, rates.from_hz, 4.0), rates.from_hz, rates.to_hz);
    CHECK_EQ(out.size(), static_cast<std::size_t>(4 * rates.to_hz));
    const double pitch = test::frequency_near(out, rates.to_hz, 98.05, 0.2, 1.0, 2.0);
    CHECK(std::abs(test::cents(pitch, 98.0)) < 1e-3);
  }
}

TEST_CASE("an equal rate is a copy, and nothing gives nothing") {
  const auto samples = sine(98.0, 48000, 0.1);
  CHECK(resampled(samples, 48000, 48000) == samples);
  CHECK(resampled({}, 44100, 48000).empty());
  CHECK_EQ(resampled(std::vector<float>(1, 0.5F), 44100, 48000).size(), 2);
}

}  // namespace hapticd::audio
