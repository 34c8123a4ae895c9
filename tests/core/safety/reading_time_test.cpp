// Speeds of devices without a clock, whose samples carry the time of their reading. Truth: a hand
// in uniform motion and the instants at which the reports of it were made.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/safety/pose_guard.h"
#include "tests/support/late_readings.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kTrip = 1.0;

DeviceSample sample_of(std::uint64_t counter, std::int64_t t_ns, const Vector3& p_DH) {
  DeviceSample sample;
  sample.counter = counter;
  sample.t_ns = t_ns;
  sample.p_DH = to_array(p_DH);
  return sample;
}

/// A sample that came.
JudgedPose judged(const DeviceSample& sample, double force_written, const GuardLimits& limits,
                  PoseGuard& guard) {
  return judge(&sample, force_written, limits, guard);
}

/// The hand at `t_ns`, at `velocity` since the begin of time.
Vector3 hand(const Vector3& velocity, std::int64_t t_ns) {
  return velocity * (1e-9 * static_cast<double>(t_ns));
}

struct Watched {
  double fastest = 0.0;
  std::optional<int> tripped;  ///< reading that did
};

/// A hand at `velocity`, watched for so many readings.
Watched watch_hand(LateReadings& readings, const Vector3& velocity, GuardLimits limits, int count) {
  PoseGuard state;
  Watched watched;
  std::uint64_t counter = 0;
  limits.velocity_trip = kTrip;
  limits.stale_ticks = kAnyTicks;
  for (int k = 0; k < count; ++k) {
    const Reading reading = readings.next();
    DeviceSample sample;
    const bool came = !reading.made_ns.empty();
    if (came) {
      counter += reading.made_ns.size();
      sample = sample_of(counter, reading.now_ns, hand(velocity, reading.made_ns.back()));
    }
    const JudgedPose seen = judge(came ? &sample : nullptr, 0.0, limits, state);
    watched.fastest = std::max(watched.fastest, seen.V_DH_D.v.norm());
    if (!watched.tripped && seen.fault == Cause::kVelocityTrip) watched.tripped = k;
  }
  return watched;
}

Vector3 velocity_of(SplitMix64& random, double speed) {
  return to_vector(random.direction()) * speed;
}

GuardLimits unseen_losses(std::int64_t interval_ns) {
  GuardLimits limits;
  limits.report_interval_ns = interval_ns;
  limits.loses_unseen = true;
  return limits;
}

}  // namespace

TEST_CASE("two reports that are read soon after each other are as far apart as they were made") {
  for (const std::int64_t later_ns : {1'000'000, 100'000, 50'000, 1, 0}) {
    CAPTURE(later_ns);
    GuardLimits limits;
    limits.velocity_trip = kTrip;
    PoseGuard state;
    (void)judged(sample_of(1, 1'000'000, {0, 0, 0.01}), 0.0, limits, state);
    const JudgedPose seen =
        judged(sample_of(2, 1'000'000 + later_ns, {0, 0, 0.01014}), 0.0, limits, state);
    CHECK(seen.V_DH_D.v.norm() == doctest::Approx(0.14));
    CHECK(seen.fault == Cause::kNone);
  }
}

TEST_CASE("a device with a clock of its own keeps its speed to the bit, however fast it reports") {
  SplitMix64 random(81);
  GuardLimits limits;
  limits.report_interval_ns = 0;
  PoseGuard state;
  std::int64_t t_ns = 0;
  Vector3 p = Vector3::Zero();
  for (std::int64_t k = 0; k < scaled(100'000); ++k) {
    const auto step_ns = static_cast<std::int64_t>(200'000 + random.below(100'000));
    const Vector3 way = velocity_of(random, 1e-3 * random.uniform());
    const Vector3 from = p;
    t_ns += step_ns;
    p += way;
    const JudgedPose seen =
        judged(sample_of(static_cast<std::uint64_t>(k) + 1, t_ns, p), 0.0, limits, state);
    if (k == 0) continue;
    const Vector3 expected = (p - from) / (static_cast<double>(step_ns) * 1e-9);
    REQUIRE(seen.V_DH_D.v == expected);
    REQUIRE((seen.fault == Cause::kVelocityTrip) == (expected.norm() > limits.velocity_trip));
  }
}

TEST_CASE("however late ticks come, no hand looks faster than it is, and a fast one is found") {
  SplitMix64 random(82);
  for (std::int64_t k = 0; k < scaled(2'000); ++k) {
    ReadingTrouble trouble;
    trouble.late = random.uniform();
    trouble.interval_ns = random.chance(0.3) ? 4'000'000 : 1'000'000;
    trouble.pause = random.chance(0.3) ? 0.01 : 0.0;
    GuardLimits limits;
    limits.report_interval_ns = trouble.interval_ns;
    CAPTURE(k);
    CAPTURE(trouble.late);
    CAPTURE(trouble.interval_ns);
    const double slow = random.uniform(0.0, 0.999);
    LateReadings readings(trouble, random.next());
    const Watched held = watch_hand(readings, velocity_of(random, slow), limits, 1000);
    REQUIRE(held.fastest <= slow * (1.0 + 1e-6));
    REQUIRE_FALSE(held.tripped.has_value());
    LateReadings others(trouble, random.next());
    const Watched let_go = watch_hand(others, velocity_of(random, 1.2), limits, 1000);
    REQUIRE(let_go.tripped.has_value());
    if (trouble.pause == 0.0) REQUIRE(*let_go.tripped <= 40);
  }
}

TEST_CASE("lost reports, stalls and pauses make no slow hand trip, and hide no fast one") {
  SplitMix64 random(83);
  for (std::int64_t k = 0; k < scaled(2'000); ++k) {
    ReadingTrouble trouble;
    trouble.interval_ns = random.chance(0.3) ? 4'000'000 : 1'000'000;
    trouble.late = random.uniform(0.0, 0.5);
    trouble.lost = random.uniform(0.0, 0.05);
    trouble.stall = random.uniform(0.0, 0.02);
    trouble.pause = random.uniform(0.0, 0.01);
    CAPTURE(k);
    LateReadings readings(trouble, random.next());
    const double slow = random.uniform(0.0, 0.95);
    const Watched held =
        watch_hand(readings, velocity_of(random, slow), unseen_losses(trouble.interval_ns), 1000);
    REQUIRE_FALSE(held.tripped.has_value());
    LateReadings others(trouble, random.next());
    const Watched let_go =
        watch_hand(others, velocity_of(random, 1.2), unseen_losses(trouble.interval_ns), 1000);
    REQUIRE(let_go.tripped.has_value());
    REQUIRE(*let_go.tripped <= 200 * trouble.interval_ns / 1'000'000);
  }
}

TEST_CASE("a jump trips at once, also where a report may have been lost") {
  for (const double way : {1.9e-3, 2.1e-3, 1.0}) {
    PoseGuard state;
    GuardLimits limits = unseen_losses(1'000'000);
    limits.velocity_trip = kTrip;
    (void)judged(sample_of(1, 1'000'000, {0, 0, 0}), 0.0, limits, state);
    const Cause found = judged(sample_of(2, 2'000'000, {0, way, 0}), 0.0, limits, state).fault;
    CHECK((found == Cause::kVelocityTrip) == (way > 2e-3));
    // And what goes on that fast in the next tick.
    CHECK(judged(sample_of(3, 3'000'000, {0, 2.0 * way, 0}), 0.0, limits, state).fault ==
          Cause::kVelocityTrip);
  }
}

TEST_CASE("an interval stated too long hides no speed for longer than a few samples") {
  for (const std::int64_t stated_ns : {2'000'000, 10'000'000, 100'000'000}) {
    CAPTURE(stated_ns);
    GuardLimits limits;
    limits.velocity_trip = kTrip;
    limits.report_interval_ns = stated_ns;
    PoseGuard state;
    int tripped = 0;
    for (int k = 1; k <= 10 && tripped == 0; ++k) {
      const auto counter = static_cast<std::uint64_t>(k);
      const Vector3 p{0, 1.2e-3 * k, 0};
      const JudgedPose seen =
          judged(sample_of(counter, std::int64_t{1'000'000} * k, p), 0.0, limits, state);
      if (seen.fault == Cause::kVelocityTrip) tripped = k;
    }
    CHECK(tripped > 0);
    CHECK(tripped <= 6);
  }
}

TEST_CASE("times at the ends of the range make no sum overflow and no speed infinite") {
  constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t from_ns : {kFirst, std::int64_t{0}, kLast}) {
    for (const std::int64_t to_ns : {kFirst, std::int64_t{0}, kLast}) {
      for (const std::int64_t interval_ns : {kFirst, std::int64_t{0}, kLast}) {
        GuardLimits limits = unseen_losses(interval_ns);
        PoseGuard state;
        (void)judged(sample_of(1, from_ns, {0, 0, 0}), 0.0, limits, state);
        const auto last = std::numeric_limits<std::uint64_t>::max();
        const JudgedPose seen = judged(sample_of(last, to_ns, {1, 0, 0}), 0.0, limits, state);
        CHECK(seen.V_DH_D.v.allFinite());
      }
    }
  }
}

}  // namespace hapticd::test
