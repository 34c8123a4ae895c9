// Instants, hysteresis and the residual amplitude of a release against closed forms.
#include "core/instrument/release_detector.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>

#include "tests/core/instrument/string_hand.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kPi2 = 2.0 * 3.14159265358979323846;

/// A tool that presses a string whose deflection is its displacement.
struct Finger {
  StringConstants string = sounding_string(98.0);
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

/// Forgets nothing, whatever the time.
Finger finger_that_remembers(double frequency) {
  Finger finger;
  finger.string = sounding_string(frequency);
  finger.string.touch_decay = 1e12;
  finger.string.decay = 1e12;
  return finger;
}

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
  finger.last = watch_touch(finger.string, finger.limits, touch, finger.detector);
  finger.touches += finger.last.began ? 1 : 0;
  finger.arms += finger.last.armed ? 1 : 0;
  finger.leaves += finger.last.ended && !finger.last.released ? 1 : 0;
  finger.releases += finger.last.released ? 1 : 0;
}

/// Presses slowly to `depth` and rests until the onset has turned away or been forgotten; leaves
/// no residual behind.
void hold(Finger& finger, double depth) {
  move(finger, 0.0);
  move(finger, -depth);
  finger.detector.residual_re = 0.0;
  finger.detector.residual_im = 0.0;
  move(finger, -depth);
}

TEST_CASE("an even unloading over tau leaves delta |sin(x) / x|, x = pi f tau") {
  SplitMix64 random(31);
  double worst = 0.0;
  const std::int64_t runs = scaled(2'000);
  for (std::int64_t run = 0; run < runs; ++run) {
    const double frequency = random.uniform(20.0, 1500.0);
    const auto dt_ns = static_cast<std::int64_t>(random.uniform(0.25e6, 5e6));
    const double ticks = random.uniform(1.05, 20.0);
    Finger finger = finger_that_remembers(frequency);
    const double depth = random.uniform(1e-3, 1e-2);
    hold(finger, depth);
    while (finger.releases == 0) move(finger, finger.distance + depth / ticks, dt_ns);
    const double x = 0.5 * kPi2 * frequency * ticks * static_cast<double>(dt_ns) * 1e-9;
    const double truth = depth * std::abs(std::sin(x) / x);
    worst = std::fmax(worst, std::abs(finger.detector.lost_amplitude - truth) / depth);
    CHECK_FALSE(finger.detector.slipped);
  }
  // The crossing of zero is exact to the last bits of the distances, half a radian per tick.
  CHECK(worst < 1e-11);
}

TEST_CASE("under a finger that damps, the residual is the damped integral") {
  Finger finger;
  const double tau = 4.5e-3;
  hold(finger, 5e-3);
  while (finger.releases == 0) move(finger, finger.distance + 5e-3 / 4.5);
  // integral over tau of exp((i omega + 1 / T_d) (s - tau)) ds / tau.
  const std::complex<double> p(1.0 / 0.03, kPi2 * 98.0);
  const double truth = 5e-3 * std::abs((1.0 - std::exp(-p * tau)) / (p * tau));
  // Within a tick the damping acts in the middle: (dt / T_d)^2 / 24 is neglected.
  CHECK(finger.detector.lost_amplitude == doctest::Approx(truth).epsilon(1e-4));
}

/// integral of delta'(s) exp(i omega s) ds of a tool that moves evenly from `before` to `after`
/// over [start, end] and presses where it is below 0.
std::complex<long double> course_integral(long double before, long double after, long double start,
                                          long double end, long double omega) {
  long double from = before < 0 ? 0.0L : 1.0L;
  long double to = after < 0 ? 1.0L : 0.0L;
  if ((before < 0) != (after < 0)) {
    const long double zero = before / (before - after);
    (after < 0 ? from : to) = zero;
  }
  if (to <= from) return 0.0L;
  const long double slope = -(after - before) / (end - start);
  const long double a = omega * (start + from * (end - start));
  const long double b = omega * (start + to * (end - start));
  return slope / omega *
         std::complex<long double>(std::sin(b) - std::sin(a), -(std::cos(b) - std::cos(a)));
}

TEST_CASE("the residual is the integral over the whole course, with contact lost and regained") {
  SplitMix64 random(34);
  const std::int64_t runs = scaled(1'000);
  long double worst = 0.0L;
  for (std::int64_t run = 0; run < runs; ++run) {
    Finger finger = finger_that_remembers(random.uniform(20.0, 500.0));
    // Any motion is one of the hand, and any gap within the hysteresis.
    finger.limits.max_acceleration = 1e9;
    finger.limits.release.release_gap = 0.02;
    const long double omega =
        static_cast<long double>(kPi2) * static_cast<long double>(finger.string.frequency);
    std::complex<long double> integral = 0.0L;
    const auto step = [&](double to) {
      const auto dt_ns = static_cast<std::int64_t>(random.uniform(0.3e6, 3e6));
      const long double start = static_cast<long double>(finger.t_ns) * 1e-9L;
      const long double before = static_cast<long double>(finger.distance);
      move(finger, to, dt_ns);
      integral += course_integral(before, static_cast<long double>(to), start,
                                  static_cast<long double>(finger.t_ns) * 1e-9L, omega);
    };
    step(-2e-3);
    for (int i = 0; i < 30; ++i) step(random.uniform(-5e-3, 3e-3));
    step(-2e-3);
    step(0.03);
    REQUIRE(finger.releases == 1);
    REQUIRE(finger.touches == 1);
    const long double truth =
        std::min(std::abs(integral), static_cast<long double>(finger.detector.largest_deflection));
    worst =
        std::max(worst, std::abs(static_cast<long double>(finger.detector.lost_amplitude) - truth));
  }
  CHECK(worst < 1e-13L);
}

TEST_CASE("up to a slip the finger goes on damping what was left before") {
  Finger finger;
  finger.string.touch_decay = 1e-3;
  hold(finger, 4e-3);
  // Lost at 4 / 5 of the tick, a whole turn later: the old residual opposes the release.
  finger.detector.residual_re = 3e-3;
  finger.detector.residual_im = 0.0;
  finger.string.frequency = 1250.0;
  move(finger, 1e-3);
  REQUIRE(finger.detector.slipped);
  CHECK(finger.detector.lost_amplitude ==
        doctest::Approx(4e-3 - 3e-3 * std::exp(-0.8)).epsilon(1e-12));
}

TEST_CASE("a string that slips off leaves its whole deflection, at any frequency") {
  for (const double frequency : {20.0, 98.0, 440.0, 1000.0, 5000.0, 2e4}) {
    Finger finger = finger_that_remembers(frequency);
    hold(finger, 4e-3);
    move(finger, 0.2e-3);
    CHECK(finger.releases == 1);
    CHECK(finger.detector.slipped);
    CHECK(finger.detector.lost_amplitude == doctest::Approx(4e-3).epsilon(1e-12));
    CHECK(finger.detector.lost_deflection == 4e-3);
  }
}

TEST_CASE(
    "a hand known to have passed the surface has not slipped, and passed it at that instant") {
  Finger finger = finger_that_remembers(440.0);
  hold(finger, 4e-3);
  finger.passing = 0.3;
  move(finger, 0.2e-3);
  CHECK(finger.releases == 1);
  CHECK_FALSE(finger.detector.slipped);
  CHECK(finger.detector.lost_ns == finger.t_ns - 700'000);
  // An even unloading over 0.3 ms.
  const double x = 0.5 * kPi2 * 440.0 * 0.3e-3;
  CHECK(finger.detector.lost_amplitude == doctest::Approx(4e-3 * std::sin(x) / x).epsilon(1e-9));
}

TEST_CASE("what a press leaves behind is forgotten under the finger") {
  Finger finger;
  move(finger, 0.0);
  move(finger, -5e-3);
  for (int i = 0; i < 300; ++i) move(finger, -5e-3);
  const double left = std::hypot(finger.detector.residual_re, finger.detector.residual_im);
  CHECK(left == doctest::Approx(5e-3 * std::exp(-0.3 / 0.03)).epsilon(0.02));
}

TEST_CASE("the amplitude left is at most the deflection, however the hand has pumped") {
  Finger finger = finger_that_remembers(100.0);
  double most = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double t = static_cast<double>(i) * 1e-3;
    move(finger, -3e-3 - 2.5e-3 * std::sin(kPi2 * 100.0 * t));
    most = std::fmax(most, -finger.distance);
  }
  CHECK(std::hypot(finger.detector.residual_re, finger.detector.residual_im) > 0.1);
  move(finger, 5e-3);
  CHECK(finger.releases == 1);
  CHECK(finger.detector.lost_amplitude == most);
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
  CHECK(finger.detector.normal_speed == doctest::Approx(-0.1).epsilon(1e-12));
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

TEST_CASE("ticks of a nanosecond, of a second and of an hour give finite amplitudes") {
  for (const std::int64_t dt_ns :
       {std::int64_t{1}, std::int64_t{1'000'000'000}, std::int64_t{3'600'000'000'000}}) {
    Finger finger;
    finger.string = sounding_string(2e4);
    move(finger, -2e-3, dt_ns);
    move(finger, -1e-3, dt_ns);
    move(finger, 1e-3, dt_ns);
    CHECK(finger.releases == 1);
    CHECK(std::isfinite(finger.detector.lost_amplitude));
    CHECK(finger.detector.lost_amplitude <= 2e-3);
  }
}

}  // namespace
}  // namespace hapticd::test
