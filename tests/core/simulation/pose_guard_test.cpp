// Input rows of the table of extremes: what a device may send and what the renderer must make of
// it.
#include "core/simulation/pose_guard.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "core/math/rotation.h"

namespace hapticd::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kDenormal = std::numeric_limits<double>::denorm_min();

PoseSample good_sample(std::int64_t t_ns) { return {t_ns, {0.1, 0.2, 0.3}, {0.5, 0.5, 0.5, 0.5}}; }

PoseGuard guard_with_pose() {
  PoseGuard guard;
  double dt = 0.0;
  CHECK(accept_pose(good_sample(1'000'000), guard, dt) == PoseVerdict::kGood);
  return guard;
}

void set_number(PoseSample& sample, std::size_t k, double value) {
  (k < 3 ? sample.p_WH[k] : sample.q_WH[k - 3]) = value;
}

}  // namespace

TEST_CASE(
    "a bad number in any of the seven holds the last pose for two ticks, then latches a fault "
    "until cleared") {
  for (const double bad :
       {kNaN, std::numeric_limits<double>::signaling_NaN(), kInf, -kInf, 1e308, -1e308}) {
    for (std::size_t k = 0; k < 7; ++k) {
      CAPTURE(bad);
      CAPTURE(k);
      PoseGuard guard = guard_with_pose();
      double dt = 0.0;
      for (int tick = 1; tick <= 4; ++tick) {
        PoseSample sample = good_sample(std::int64_t{1'000'000} * (1 + tick));
        set_number(sample, k, bad);
        const PoseVerdict verdict = accept_pose(sample, guard, dt);
        CHECK(verdict == (tick <= 2 ? PoseVerdict::kHeld : PoseVerdict::kFault));
        CHECK(guard.X_WH.p == Vector3(0.1, 0.2, 0.3));
        CHECK(guard.V_WH.v == Vector3::Zero());
        CHECK(dt == 0.0);
      }
      CHECK(accept_pose(good_sample(9'000'000), guard, dt) == PoseVerdict::kFault);
      CHECK(guard.bad_total == 4);
    }
  }
}

TEST_CASE("a zero, denormal or far from unit quaternion is a bad sample") {
  for (const Array4& q : {Array4{0, 0, 0, 0}, Array4{kDenormal, kDenormal, kDenormal, kDenormal},
                          Array4{0.49, 0, 0, 0}, Array4{1.5, 1.5, 0, 0}}) {
    PoseGuard guard = guard_with_pose();
    double dt = 0.0;
    CHECK(accept_pose({2'000'000, {0, 0, 0}, q}, guard, dt) == PoseVerdict::kHeld);
  }
}

TEST_CASE("a quaternion with norm between a half and two is normalised") {
  for (const double norm : {0.5, 0.9, 1.1, 2.0}) {
    PoseGuard guard;
    double dt = 0.0;
    CHECK(accept_pose({0, {0, 0, 0}, {norm * 0.6, 0, norm * 0.8, 0}}, guard, dt) ==
          PoseVerdict::kGood);
    CHECK(std::abs(guard.X_WH.q.norm() - 1.0) < 1e-15);
    CHECK(guard.X_WH.q.y() == doctest::Approx(0.8).epsilon(1e-15));
  }
}

TEST_CASE("denormal and negative zero positions are ordinary numbers") {
  PoseGuard guard;
  double dt = 0.0;
  CHECK(accept_pose({0, {kDenormal, -0.0, -kDenormal}, {1, -0.0, kDenormal, 0}}, guard, dt) ==
        PoseVerdict::kGood);
  CHECK(guard.X_WH.p.norm() < 1e-300);
}

TEST_CASE("without any good pose yet the very first bad sample is a fault") {
  PoseGuard guard;
  double dt = 0.0;
  CHECK(accept_pose({0, {kNaN, 0, 0}, {1, 0, 0, 0}}, guard, dt) == PoseVerdict::kFault);
}

TEST_CASE("one good sample between bad ones starts the count of held ticks afresh") {
  PoseGuard guard = guard_with_pose();
  double dt = 0.0;
  for (int round = 0; round < 10; ++round) {
    PoseSample bad = good_sample(0);
    bad.p_WH[1] = kNaN;
    CHECK(accept_pose(bad, guard, dt) == PoseVerdict::kHeld);
    CHECK(accept_pose(bad, guard, dt) == PoseVerdict::kHeld);
    CHECK(accept_pose(good_sample(2'000'000 + round), guard, dt) == PoseVerdict::kGood);
  }
}

TEST_CASE("velocity follows true elapsed time and is left alone by repeated or backward stamps") {
  PoseGuard guard;
  double dt = 0.0;
  CHECK(accept_pose({0, {0, 0, 0}, {1, 0, 0, 0}}, guard, dt) == PoseVerdict::kGood);
  CHECK(dt == 0.0);
  CHECK(accept_pose({2'000'000, {0.004, 0, 0}, to_array(exp_rotation({0, 0, 0.01}))}, guard, dt) ==
        PoseVerdict::kGood);
  CHECK(dt == doctest::Approx(2e-3).epsilon(1e-15));
  CHECK(guard.V_WH.v.x() == doctest::Approx(2.0).epsilon(1e-12));
  CHECK(guard.V_WH.w.z() == doctest::Approx(5.0).epsilon(1e-12));

  for (const std::int64_t stamp :
       {std::int64_t{2'000'000}, std::int64_t{1'000'000}, std::int64_t{-5}}) {
    CHECK(accept_pose({stamp, {0.005, 0, 0}, {1, 0, 0, 0}}, guard, dt) == PoseVerdict::kGood);
    CHECK(dt == 0.0);
    CHECK(guard.V_WH.v.x() == doctest::Approx(2.0).epsilon(1e-12));
  }
}

TEST_CASE("a five millisecond gap is integrated whole and a longer pause counts as five") {
  PoseGuard guard;
  double dt = 0.0;
  CHECK(accept_pose(good_sample(0), guard, dt) == PoseVerdict::kGood);
  CHECK(accept_pose(good_sample(5'000'000), guard, dt) == PoseVerdict::kGood);
  CHECK(dt == doctest::Approx(5e-3).epsilon(1e-15));
  CHECK(accept_pose(good_sample(9'000'000'000), guard, dt) == PoseVerdict::kGood);
  CHECK(dt == kMaxElapsed);
}

}  // namespace hapticd::test
