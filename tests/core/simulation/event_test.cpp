// What the events of a tick say: the instant inside the tick at which a hand on a straight way
// passes a string's surface, and its speed there, against the geometry of that way.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/instrument/string_motion.h"
#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// Allowed error of an instant, s; of a wave, which is known by the sub-step.
constexpr double kInstantError = 5e-6;
constexpr double kWaveInstantError = 1.1e-3 / kSubSteps;
/// Allowed error of a speed, relative.
constexpr double kSpeedError = 0.02;
/// The same of a release: of a tick that ends within the clearance of the surface the share that
/// the string has in the displacement is known to a few percent.
constexpr double kReleaseError = 0.05;

/// A hand on a straight way at constant speed: p_0 + v t.
struct Way {
  Vector3 p_0;
  Vector3 v;

  [[nodiscard]] Vector3 at(double t) const { return p_0 + v * t; }
  /// When the distance from string 0, which lies on the x axis, becomes `d`: first or last time.
  [[nodiscard]] double crossing(double d, bool first) const {
    const double a = v.y() * v.y() + v.z() * v.z();
    const double b = p_0.y() * v.y() + p_0.z() * v.z();
    const double c = p_0.y() * p_0.y() + p_0.z() * p_0.z() - d * d;
    const double root = std::sqrt(b * b - a * c);
    return (-b + (first ? -root : root)) / a;
  }
};

double seconds(std::int64_t t_ns) { return 1e-9 * static_cast<double>(t_ns); }

/// A way from above onto string 0 at `speed`, that begins clear of it.
Way random_approach(SplitMix64& random, double speed) {
  const double angle = random.uniform(-0.6, 0.6);
  const Vector3 v = speed * Vector3(random.uniform(-0.5, 0.5), -std::cos(angle), std::sin(angle));
  const Vector3 aim(random.uniform(0.1, 1.0), 0.0, random.uniform(-2e-3, 2e-3));
  return {aim - v * random.uniform(0.02, 0.021), v};
}

}  // namespace

TEST_CASE("a touch is reported at the instant at which the hand reaches the string") {
  SplitMix64 random(11);
  double worst = 0.0;
  for (const Preset& preset : all_presets()) {
    for (std::int64_t i = scaled(200); i > 0; --i) {
      Instrument guqin(1, preset.string, preset.options);
      Way way = random_approach(random, random.uniform(0.1, 2.0));
      way.p_0 -= way.v.normalized() * 0.02;
      for (int k = 0; k < 1000 && count(guqin.events, StringEventKind::kTouch) == 0; ++k) {
        guqin.tick(way.at(1e-3 * k + 1e-3));
      }
      const auto touches = of_kind(guqin.events, StringEventKind::kTouch);
      REQUIRE(touches.size() == 1);
      const double error =
          std::abs(seconds(touches[0].t_ns) - way.crossing(felt_distance(guqin), true));
      worst = std::max(worst, error);
      if (error > (sounds(preset) ? kWaveInstantError : kInstantError))
        FAIL_CHECK(std::string(preset.name) << ": " << error << " s");
    }
  }
  MESSAGE("largest error of the instant of a touch: " << worst * 1e6 << " us");
}

TEST_CASE("a touch reports normal and tangential speed of the hand against a string at rest") {
  SplitMix64 random(12);
  double worst = 0.0;
  for (const Preset& preset : all_presets()) {
    for (std::int64_t i = scaled(200); i > 0; --i) {
      Instrument guqin(1, preset.string, preset.options);
      const double speed = random.uniform(0.05, 3.0);
      Way way = random_approach(random, speed);
      way.p_0 -= way.v.normalized() * 0.02;
      // The second touch of the same string has to be as right as the first.
      for (int touch = 0; touch < 2; ++touch) {
        guqin.events.clear();
        guqin.tick(way.p_0);
        for (int k = 0; k < 2000 && count(guqin.events, StringEventKind::kTouch) == 0; ++k) {
          guqin.tick(way.at(1e-3 * (k + 1)));
        }
        const auto touches = of_kind(guqin.events, StringEventKind::kTouch);
        REQUIRE(touches.size() == 1);
        const Vector3 p = way.at(way.crossing(felt_distance(guqin), true));
        const Vector3 nhat = Vector3(0.0, p.y(), p.z()).normalized();
        const double normal = -way.v.dot(nhat);
        const double tangential = (way.v + normal * nhat).norm();
        const double error = std::max(std::abs(touches[0].normal_speed - normal),
                                      std::abs(touches[0].tangential_speed - tangential));
        worst = std::max(worst, error / speed);
        if (error > kSpeedError * speed) {
          FAIL_CHECK(std::string(preset.name)
                     << ", touch " << touch << " at " << speed
                     << " m/s: " << touches[0].normal_speed << " for " << normal << ", "
                     << touches[0].tangential_speed << " for " << tangential);
        }
        // Away as it came, until the string is still.
        for (int k = 0; k < 40; ++k) guqin.tick(Vector3(guqin.p_WH - way.v * 1e-3));
        for (int k = 0; k < 6000 && guqin.reading(0) != nullptr; ++k) guqin.tick(guqin.p_WH);
        CHECK(guqin.reading(0) == nullptr);
      }
    }
  }
  MESSAGE("largest error of the speed of a touch: " << worst * 100.0 << " %");
}

namespace {

/// A finger that passes under string 0 along z at constant speed, `below` its axis.
struct Passing {
  double speed;
  double below;
  double start;  ///< share of a tick at which it starts
};

/// All that happens while it does.
Instrument passed_under(const Preset& preset, const Passing& passing) {
  Instrument guqin(1, preset.string, preset.options);
  const Vector3 from(0.33, -passing.below, -9e-3 + passing.start * passing.speed * 1e-3);
  guqin.tick(Vector3(from));
  for (int k = 1; k * passing.speed < 20.0; ++k) {
    guqin.tick(Vector3(from + Vector3(0.0, 0.0, passing.speed * 1e-3 * k)));
  }
  return guqin;
}

}  // namespace

TEST_CASE("a tone's amplitude is the largest deflection of its touch, at any speed") {
  double worst = 0.0;
  for (const Preset& preset : {paper_preset(), deflecting_preset()}) {
    for (const double speed : {0.1, 0.15, 0.3, 0.6, 1.2, 3.0}) {
      for (const double start : {0.0, 0.3, 0.7}) {
        const Passing passing{speed, 3e-3, start};
        const Instrument guqin = passed_under(preset, passing);
        const auto tones = of_kind(guqin.events, StringEventKind::kTone);
        CAPTURE(std::string(preset.name));
        CAPTURE(speed);
        REQUIRE(tones.size() == 1);
        // Small deflections: k0 at 0.3 of the string against kc = 1 kN/m.
        const double k0 = 30.0 / (1.1 * 0.3 * 0.7);
        const double share =
            preset.string.model == StringContact::kStraight ? 1.0 : 1000.0 / (1000.0 + k0);
        // Of the tick nearest to the middle, at most half a tick's way off it.
        const double s = felt_distance(guqin);
        const double deepest = share * (s - passing.below);
        const double least = share * (s - std::hypot(passing.below, 0.5e-3 * speed));
        worst = std::max(worst, std::abs(tones[0].amplitude - deepest) / deepest);
        CHECK(tones[0].amplitude < 1.03 * deepest);
        CHECK(tones[0].amplitude > 0.97 * least);
      }
    }
  }
  MESSAGE("largest error of a tone's amplitude: " << worst * 100.0 << " % of the deflection");
}

TEST_CASE("a release reports the speed of the hand against the string that followed it") {
  double worst = 0.0;
  for (const Preset& preset : {paper_preset(), deflecting_preset()}) {
    for (const double speed : {0.05, 0.1, 0.2, 0.5, 1.0, 2.0}) {
      for (const double start : {0.0, 0.3, 0.7}) {
        const Passing passing{speed, 3e-3, start};
        const Instrument guqin = passed_under(preset, passing);
        const auto releases = of_kind(guqin.events, StringEventKind::kRelease);
        REQUIRE(releases.size() == 1);
        const double s = felt_distance(guqin);
        const double sine = 3e-3 / s;
        const double along = std::sqrt(1.0 - sine * sine) * speed;
        const double k0 = 30.0 / (1.1 * 0.3 * 0.7);
        const double left =
            preset.string.model == StringContact::kStraight ? 1.0 : k0 / (k0 + 1000.0);
        const double error = std::max(std::abs(releases[0].normal_speed + along * left),
                                      std::abs(releases[0].tangential_speed - sine * speed));
        worst = std::max(worst, error / speed);
        CHECK(error < kReleaseError * speed);
      }
    }
  }
  MESSAGE("largest error of the speed of a release: " << worst * 100.0 << " %");
}

TEST_CASE("a tone carries what the string is, where and how it was let go, and its glide") {
  for (Preset preset : {paper_preset(), deflecting_preset()}) {
    CAPTURE(std::string(preset.name));
    preset.options.pitch_glide = true;
    const Instrument guqin = passed_under(preset, {0.6, 2e-3, 0.4});
    const auto tones = of_kind(guqin.events, StringEventKind::kTone);
    const auto releases = of_kind(guqin.events, StringEventKind::kRelease);
    REQUIRE(tones.size() == 1);
    REQUIRE(releases.size() == 1);
    const StringEvent& tone = tones[0];
    CHECK(tone.string == 0);
    CHECK(tone.t_ns == releases[0].t_ns);
    CHECK(tone.lambda == within(0.33 / 1.1, 1e-4));
    CHECK(tone.frequency == 65.4);
    CHECK(tone.decay == preset.string.decay);
    CHECK(tone.normal_speed == releases[0].normal_speed);
    CHECK(tone.tangential_speed == releases[0].tangential_speed);

    // Straight from Eq. 10-12: the string drawn aside by the amplitude.
    const long double L = 1.1L;
    const long double a = static_cast<long double>(tone.amplitude);
    const long double EA = 1.9e11L * 3.14159265358979323846L * 0.34e-3L * 0.34e-3L;
    const auto extra = [&](long double lambda) {
      return EA * (std::hypot(lambda * L, a) + std::hypot((1.0L - lambda) * L, a) - L) / L;
    };
    const long double force =
        (30.0L + extra(0.3L)) * (a / std::hypot(0.3L * L, a) + a / std::hypot(0.7L * L, a));
    const bool paper = preset.string.model == StringContact::kStraight;
    const long double level = paper ? force : a / 5e-3L;
    CHECK(tone.level == within(static_cast<double>(level), 1e-6));
    const long double pi = 3.14159265358979323846L;
    const long double at = static_cast<long double>(tone.lambda);
    const long double share = 2.0L * std::pow(std::sin(pi * at) / pi, 2.0L) / (at * (1.0L - at));
    const long double cents =
        1200.0L * std::log2(std::sqrt(1.0L + extra(at) / 60.0L * (1.0L + 0.5L * share)));
    CHECK(tone.glide_cents == within(static_cast<double>(cents), 1e-6));
    CHECK(tone.glide_decay == 0.5 * preset.string.decay);
  }
}

}  // namespace hapticd::test
