// What the events of a tick say: the instant inside the tick at which a hand on a straight way
// passes a string's surface, and its speed there, against the geometry of that way.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Allowed error of an instant, s.
constexpr double kInstantError = 5e-6;
/// Allowed error of a speed, relative.
constexpr double kSpeedError = 0.02;

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

TEST_CASE("a touch is reported within 5 us of the instant at which the hand reaches the string") {
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
      if (error > kInstantError) FAIL_CHECK(std::string(preset.name) << ": " << error << " s");
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

}  // namespace hapticd::test
