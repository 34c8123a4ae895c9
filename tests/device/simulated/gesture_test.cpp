// Truth: the quintic of Flash and Hogan at thirds (17/81, 64/81), its peak speed 15/8 of the mean,
// straight lines and single rotations.
#include "device/simulated/gesture.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/math/rotation.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

GestureLeg leg(const Array3& p, std::int64_t duration_ms, std::int64_t hold_ms = 0,
               bool linear = false) {
  return {{p, {1.0, 0.0, 0.0, 0.0}}, duration_ms * kMs, hold_ms * kMs, linear};
}

bool near(const Vector3& a, const Vector3& b, double tolerance) {
  return (a - b).norm() <= tolerance;
}

}  // namespace

TEST_CASE("a minimum-jerk motion is 17/81 of the way at a third and 64/81 at two thirds") {
  GestureMotion motion;
  motion.legs = {leg({0, 0, 0}, 0), leg({0.3, -0.6, 0.9}, 300)};
  GesturePlayer player(Pose{});
  player.play(motion.track(), 1);
  const Vector3 way(0.3, -0.6, 0.9);
  CHECK(near(player.advance(100 * kMs).p, way * (17.0 / 81.0), 1e-15));
  CHECK(near(player.advance(100 * kMs).p, way * (64.0 / 81.0), 1e-15));
  CHECK(near(player.advance(100 * kMs).p, way, 1e-15));
  CHECK(!player.progress().playing);
  CHECK(player.progress().finished == 1);
}

TEST_CASE("the fastest moment of a minimum-jerk motion is 15/8 of its mean, its ends at rest") {
  GestureMotion motion;
  motion.legs = {leg({0, 0, 0}, 0), leg({1, 0, 0}, 1000)};
  GesturePlayer player(Pose{});
  player.play(motion.track(), 1);
  double fastest = 0.0;
  double last = 0.0;
  double first_step = -1.0;
  for (int i = 0; i < 1000; ++i) {
    const double x = player.advance(kMs).p.x();
    if (first_step < 0.0) first_step = x - last;
    fastest = std::max(fastest, x - last);
    last = x;
  }
  CHECK(std::abs(fastest * 1000 - kMinimumJerkPeak) < 1e-5);
  CHECK(first_step < 1.1e-8);
  CHECK(last == 1.0);
}

TEST_CASE("a linear motion has constant speed, a hold none") {
  GestureMotion motion;
  motion.legs = {leg({0, 0, 0}, 0, 50), leg({1, 0, 0}, 100, 30, true),
                 leg({1, 2, 0}, 100, 0, true)};
  GesturePlayer player(Pose{});
  player.play(motion.track(), 1);
  CHECK(player.advance(49 * kMs).p == Vector3(0, 0, 0));
  CHECK(near(player.advance(26 * kMs).p, {0.25, 0, 0}, 1e-15));
  CHECK(near(player.advance(50 * kMs).p, {0.75, 0, 0}, 1e-15));
  CHECK(player.advance(30 * kMs).p == Vector3(1, 0, 0));
  CHECK(player.advance(24 * kMs).p == Vector3(1, 0, 0));
  CHECK(near(player.advance(51 * kMs).p, {1, 1, 0}, 1e-15));
  CHECK(duration_ns(motion.track()) == 280 * kMs);
  CHECK(std::abs(player.progress().fraction - 230.0F / 280.0F) < 1e-6F);
}

TEST_CASE("orientation turns about one axis, with the same timing as the position") {
  const Vector3 phi(0.3, -1.2, 0.7);
  GestureMotion motion;
  motion.legs = {leg({0, 0, 0}, 0), leg({0, 0, 0}, 300)};
  motion.legs[1].point.q_DH = to_array(exp_rotation(phi));
  GesturePlayer player(Pose{});
  player.play(motion.track(), 1);
  CHECK(near(log_rotation(player.advance(100 * kMs).q), phi * (17.0 / 81.0), 1e-14));
  CHECK(near(log_rotation(player.advance(200 * kMs).q), phi, 1e-14));
}

TEST_CASE(
    "a gesture begins gently from wherever the target is: at rest, and no faster than 0.3 m/s") {
  GestureMotion motion;
  motion.legs = {leg({0.4, 0, 0}, 0), leg({0.4, 0.1, 0}, 100)};
  GesturePlayer player(Pose{{1, 0, 0, 0}, {0.0, 0.2, 0.0}});
  player.play(motion.track(), 1);
  Vector3 last(0.0, 0.2, 0.0);
  double fastest = 0.0;
  int ticks = 0;
  while ((last - Vector3(0.4, 0, 0)).norm() > 1e-12 && ticks < 10'000) {
    const Vector3 p = player.advance(kMs).p;
    if (ticks == 0) CHECK((p - last).norm() < 1e-7);
    fastest = std::max(fastest, (p - last).norm());
    last = p;
    ++ticks;
  }
  CHECK(fastest <= kApproachSpeed * 1e-3 * (1 + 1e-9));
  CHECK(fastest > 0.99 * kApproachSpeed * 1e-3);
  // 15/8 of the distance over 0.3 m/s.
  CHECK(std::abs(ticks - 1000 * 1.875 * std::hypot(0.4, 0.2) / 0.3) < 10);
  CHECK(player.progress().fraction < 0.2F);
}

TEST_CASE(
    "a gesture that ends where it begins repeats without a pause, exactly as often as asked") {
  GestureMotion motion;
  motion.legs = {leg({0, 0, 0}, 0), leg({0.1, 0, 0}, 70), leg({0, 0, 0}, 30)};
  GesturePlayer player(Pose{});
  player.play(motion.track(), 3);
  Vector3 at_37[3];
  for (auto& p : at_37) {
    p = player.advance(37 * kMs).p;
    player.advance(63 * kMs);
  }
  CHECK(at_37[0] == at_37[1]);
  CHECK(at_37[0] == at_37[2]);
  CHECK(player.progress().finished == 3);
  CHECK(!player.progress().playing);
  CHECK(player.advance(1000 * kMs).p == Vector3(0, 0, 0));
}

TEST_CASE("no time is lost where one repetition follows another, however it is asked") {
  GestureMotion motion;
  motion.legs = {leg({0, 0, 0}, 0), leg({0.1, 0, 0}, 70), leg({0, 0, 0}, 30)};
  GesturePlayer fine(Pose{});
  GesturePlayer coarse(Pose{});
  fine.play(motion.track(), 0);
  coarse.play(motion.track(), 0);
  // 137 ms ends inside a leg of the next repetition.
  for (int i = 0; i < 137; ++i) fine.advance(kMs);
  coarse.advance(60 * kMs);
  coarse.advance(77 * kMs);
  CHECK(near(coarse.advance(kMs).p, fine.advance(kMs).p, 1e-15));
  CHECK(fine.target().p.x() > 0.01);
}

TEST_CASE("a gesture told to repeat for ever does, until it is stopped where it is") {
  GestureMotion motion;
  motion.legs = {leg({0, 0, 0}, 0), leg({0.1, 0, 0}, 10), leg({0, 0, 0}, 10)};
  GesturePlayer player(Pose{});
  player.play(motion.track(), 0);
  for (int i = 0; i < 20'005; ++i) player.advance(kMs);
  CHECK(player.progress().playing);
  CHECK(player.progress().finished == 1000);
  const Vector3 p = player.target().p;
  CHECK(p.x() > 0.01);
  player.stop();
  CHECK(player.advance(kMs).p == p);
  CHECK(!player.progress().playing);
}

TEST_CASE("samples are joined by straight lines at their rate") {
  GestureMotion motion;
  motion.rate = 50.0;
  for (int i = 0; i < 4; ++i) motion.samples.push_back({{i * i * 0.01, 0, 0}, {1, 0, 0, 0}});
  GesturePlayer player(Pose{});
  player.play(motion.track(), 1);
  CHECK(duration_ns(motion.track()) == 60 * kMs);
  CHECK(near(player.advance(10 * kMs).p, {0.005, 0, 0}, 1e-15));
  CHECK(near(player.advance(20 * kMs).p, {0.025, 0, 0}, 1e-15));
  CHECK(near(player.advance(20 * kMs).p, {0.065, 0, 0}, 1e-14));
  CHECK(player.advance(10 * kMs).p == Vector3(0.09, 0, 0));
  CHECK(!player.progress().playing);
}

TEST_CASE("gestures without length, or with one sample, are over at once and hang nobody") {
  GestureMotion still;
  still.legs.assign(500, leg({0, 0, 0}, 0));
  GesturePlayer player(Pose{});
  player.play(still.track(), 0);
  for (int i = 0; i < 100; ++i) player.advance(kMs);
  CHECK(player.progress().finished > 0);
  GestureMotion point;
  point.rate = 100.0;
  point.samples.push_back({{0, 0, 0}, {1, 0, 0, 0}});
  player.play(point.track(), 1);
  player.advance(kMs);
  CHECK(!player.progress().playing);
  player.play(GestureTrack{}, 1);
  CHECK(!player.progress().playing);
}

}  // namespace hapticd::test
