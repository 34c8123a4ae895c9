// Instants, hysteresis and what a release leaves ringing.
#include "core/instrument/release_detector.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/core/instrument/string_hand.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kPi2 = 2.0 * 3.14159265358979323846;

/// A tool that presses a string whose deflection is its displacement.
struct Finger {
  TouchLimits limits;
  ReleaseDetector detector;
  double distance = 1e-3;
  double passing = -1.0;  ///< what the caller knows of the next tick
  std::int64_t t_ns = 0;
  TouchReport last;
  int touches = 0;
  int arms = 0;
  int leaves = 0;
  int releases = 0;
};

void move(Finger& finger, double distance, std::int64_t dt_ns = kTick_ns) {
  StringTouch touch;
  touch.distance_before = finger.distance;
  touch.distance = distance;
  touch.passing = finger.passing;
  touch.deflection = std::fmax(-distance, 0.0);
  touch.force = 100.0 * touch.deflection;
  touch.normal_speed = (finger.distance - distance) / (static_cast<double>(dt_ns) * 1e-9);
  touch.tangential_speed = 0.25;
  finger.distance = distance;
  finger.t_ns += dt_ns;
  touch.time = {finger.t_ns, dt_ns};
  finger.last = watch_touch(finger.limits, touch, finger.detector);
  finger.touches += finger.last.began ? 1 : 0;
  finger.arms += finger.last.armed ? 1 : 0;
  finger.leaves += finger.last.ended && !finger.last.released ? 1 : 0;
  finger.releases += finger.last.released ? 1 : 0;
}

/// Presses to `depth` and rests.
void hold(Finger& finger, double depth) {
  move(finger, 0.0);
  move(finger, -depth);
  move(finger, -depth);
}

TEST_CASE("what a touch leaves ringing is its largest deflection, however it ends") {
  SplitMix64 random(31);
  const std::int64_t runs = scaled(2'000);
  for (std::int64_t run = 0; run < runs; ++run) {
    Finger finger;
    double most = 0.0;
    const int ticks = 5 + static_cast<int>(random.uniform() * 50.0);
    for (int k = 0; k < ticks; ++k) {
      move(finger, random.uniform(-5e-3, -0.4e-3));
      most = std::fmax(most, -finger.distance);
    }
    const double last = -finger.distance;
    const double step = std::exp(random.uniform(std::log(1e-5), std::log(1e-2)));
    while (finger.releases == 0) move(finger, finger.distance + step);
    CHECK(finger.detector.largest_deflection == most);
    CHECK(finger.detector.lost_deflection > 0.0);
    CHECK(finger.detector.lost_deflection <= last);
  }
}

TEST_CASE("a string that goes further than the hand can have moved has slipped off") {
  Finger finger;
  hold(finger, 4e-3);
  move(finger, 0.2e-3);
  CHECK(finger.releases == 1);
  CHECK(finger.detector.slipped);
  CHECK(finger.detector.lost_deflection == 4e-3);
}

TEST_CASE(
    "a hand known to have passed the surface has not slipped, and passed it at that instant") {
  Finger finger;
  hold(finger, 4e-3);
  finger.passing = 0.3;
  move(finger, 0.2e-3);
  CHECK(finger.releases == 1);
  CHECK_FALSE(finger.detector.slipped);
  CHECK(finger.detector.lost_ns == finger.t_ns - 700'000);
}

TEST_CASE("touch and loss fall on the instants at which a steady tool crosses the surface") {
  SplitMix64 random(32);
  const std::int64_t runs = scaled(20'000);
  std::int64_t worst_ns = 0;
  for (std::int64_t run = 0; run < runs; ++run) {
    Finger finger;
    const auto dt_ns = static_cast<std::int64_t>(random.uniform(0.2e6, 5e6));
    const double dt = static_cast<double>(dt_ns) * 1e-9;
    const double speed = random.uniform(0.01, 0.2);
    finger.distance = random.uniform(0.1, 3.0) * speed * dt;
    const double touch_s = finger.distance / speed;
    while (finger.touches == 0) move(finger, finger.distance - speed * dt, dt_ns);
    worst_ns = std::max(worst_ns, std::abs(finger.last.began_ns -
                                           static_cast<std::int64_t>(std::llround(touch_s * 1e9))));
    for (int i = 0; i < 5; ++i) move(finger, finger.distance - speed * dt, dt_ns);
    const double turned_s = static_cast<double>(finger.t_ns) * 1e-9;
    const double lost_s = turned_s - finger.distance / speed;
    while (finger.leaves + finger.releases == 0) {
      move(finger, finger.distance + speed * dt, dt_ns);
    }
    worst_ns = std::max(worst_ns, std::abs(finger.last.ended_ns -
                                           static_cast<std::int64_t>(std::llround(lost_s * 1e9))));
  }
  CHECK(worst_ns <= 1);
}

TEST_CASE("a touch arms where the deflection passes the threshold, once") {
  Finger finger;
  move(finger, 0.1e-3);
  move(finger, -0.1e-3);
  CHECK(finger.arms == 0);
  move(finger, -0.5e-3);
  CHECK(finger.arms == 1);
  // From 0.1 to 0.5 mm: 0.3 mm in the middle of the third tick.
  CHECK(finger.last.armed_ns == 2'500'000);
  move(finger, -0.2e-3);
  move(finger, -0.9e-3);
  CHECK(finger.arms == 1);
}

TEST_CASE("a touch of exactly the threshold is not armed and its end no release") {
  Finger finger;
  move(finger, -0.3e-3);
  move(finger, 0.05);
  CHECK(finger.arms == 0);
  CHECK(finger.leaves == 1);
  CHECK(finger.releases == 0);
}

TEST_CASE("a lost contact is an end only beyond the release gap, at the instant of the loss") {
  Finger finger;
  move(finger, 1e-3);
  move(finger, -1e-3);
  move(finger, -0.05e-3);
  move(finger, 0.05e-3);
  CHECK(finger.releases == 0);
  for (int i = 0; i < 5; ++i) move(finger, 0.1e-3);
  CHECK(finger.releases == 0);
  CHECK(finger.touches == 1);
  move(finger, 0.101e-3);
  CHECK(finger.releases == 1);
  CHECK(finger.last.ended_ns == 3'500'000);
  CHECK(finger.detector.normal_speed == within(-0.1, 1e-12));
  CHECK(finger.detector.tangential_speed == 0.25);
}

TEST_CASE("contact regained within the gap goes on with the same touch") {
  Finger finger;
  move(finger, -1e-3);
  for (int i = 0; i < 20; ++i) move(finger, i % 2 == 0 ? 0.09e-3 : -0.09e-3);
  CHECK(finger.touches == 1);
  CHECK(finger.releases == 0);
  move(finger, 1e-3);
  CHECK(finger.releases == 1);
}

TEST_CASE("ten seconds of hovering with noise and tremor arm nothing") {
  SplitMix64 random(33);
  for (const double height : {0.1e-3, 0.05e-3, 0.0, -0.1e-3}) {
    Finger finger;
    const std::int64_t ticks = scaled(10'000);
    for (std::int64_t k = 0; k < ticks; ++k) {
      const double t = static_cast<double>(k) * 1e-3;
      const double tremor = 0.1e-3 * std::sin(kPi2 * 9.0 * t);
      move(finger, height + tremor + random.uniform(-20e-6, 20e-6));
    }
    CHECK(finger.arms == 0);
    CHECK(finger.releases == 0);
  }
}

TEST_CASE("a string that does not yield is touched and left, and never armed") {
  Finger finger;
  finger.limits.can_arm = false;
  move(finger, -5e-3);
  move(finger, 5e-3);
  CHECK(finger.touches == 1);
  CHECK(finger.arms == 0);
  CHECK(finger.leaves == 1);
}

TEST_CASE("the envelope is touched on entering it, and again only after the tool has been out") {
  Finger finger;
  finger.limits.envelope = 2e-3;
  finger.distance = 3e-3;
  move(finger, 1e-3);
  CHECK(finger.touches == 1);
  CHECK(finger.last.began_ns == 500'000);
  // The touch ends a release gap outside the envelope, wherever that has gone.
  finger.limits.envelope = 0.95e-3;
  move(finger, 1e-3);
  CHECK(finger.leaves == 0);
  finger.limits.envelope = 0.89e-3;
  move(finger, 1e-3);
  CHECK(finger.leaves == 1);
  // After a release the tool is still within: only the string itself can be touched.
  finger.detector.outside = false;
  finger.limits.envelope = 2e-3;
  move(finger, 0.5e-3);
  move(finger, 0.4e-3);
  CHECK(finger.touches == 1);
  move(finger, 2.5e-3);
  move(finger, 0.5e-3);
  CHECK(finger.touches == 2);
}

TEST_CASE("inside an envelope that it has not left, the tool can still touch the string") {
  Finger finger;
  finger.limits.envelope = 2e-3;
  finger.detector.outside = false;
  finger.distance = 0.5e-3;
  move(finger, -0.5e-3);
  CHECK(finger.touches == 1);
  CHECK(finger.last.began_ns == 500'000);
}

TEST_CASE("the refractory time counts from the release that sounded") {
  ReleaseOptions options;
  ReleaseDetector detector;
  CHECK_FALSE(refractory(options, detector, 0));
  detector.sounded = true;
  detector.sounded_ns = 1'000'000'000;
  CHECK(refractory(options, detector, 1'019'999'999));
  CHECK_FALSE(refractory(options, detector, 1'020'000'000));
  options.refractory = 0.0;
  CHECK_FALSE(refractory(options, detector, 1'000'000'000));
}

TEST_CASE("a release is seen with ticks of a nanosecond, of a second and of an hour") {
  for (const std::int64_t dt_ns :
       {std::int64_t{1}, std::int64_t{1'000'000'000}, std::int64_t{3'600'000'000'000}}) {
    Finger finger;
    move(finger, -2e-3, dt_ns);
    move(finger, -1e-3, dt_ns);
    move(finger, 1e-3, dt_ns);
    CHECK(finger.releases == 1);
    CHECK(finger.detector.largest_deflection == 2e-3);
  }
}

}  // namespace
}  // namespace hapticd::test
