// The simulated device as a device: contract, reports, determinism, arms taking over.
#include "device/simulated/simulated_device.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "core/math/rotation.h"
#include "tests/device/api/device_contract.h"
#include "tests/support/random.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

DeviceProfile usual() {
  DeviceProfile profile;
  profile.name = {'u', 's', 'u', 'a', 'l'};
  profile.peak_force = 22.0;
  profile.peak_torque = 0.5;
  profile.delay = 1e-3;
  profile.motor_lag = 1e-3;
  profile.coulomb_friction = {0.1, 0.1, 0.1};
  profile.coulomb_torque = {1e-3, 1e-3, 1e-3};
  profile.position_resolution = {2e-5, 2e-5, 2e-5};
  profile.rotation_resolution = {1e-4, 1e-4, 1e-4};
  return profile;
}

/// There and back, turning.
GestureMotion swing() {
  GestureMotion motion;
  motion.legs.resize(3);
  motion.legs[1] = {
      {{0.1, -0.05, 0.02}, to_array(exp_rotation({0.1, 0.5, -0.3}))}, 300 * kMs, 50 * kMs, false};
  motion.legs[2] = {motion.legs[0].point, 200 * kMs, 0, true};
  return motion;
}

bool same(const PlantState& a, const PlantState& b) {
  return a.X_DH.p == b.X_DH.p && a.X_DH.q.coeffs() == b.X_DH.q.coeffs() && a.V_DH.v == b.V_DH.v &&
         a.V_DH.w == b.V_DH.w;
}

}  // namespace

TEST_CASE("the simulated device keeps the contract of devices, with every arm and a gesture") {
  const GestureMotion motion = swing();
  for (const ArmKind arm :
       {ArmKind::kOff, ArmKind::kLight, ArmKind::kFirm, ArmKind::kAdversarial}) {
    SimulatedDevice device(usual(), {.arm = arm});
    device.play(motion.track(), 0);
    check_device_contract(device, virtual_ticks(kMs), 500);
  }
}

TEST_CASE("changing arm, seed and gesture while it runs leaves the heap alone") {
  const GestureMotion motion = swing();
  SimulatedDevice device(usual(), {});
  DeviceSample sample;
  const NoHeapScope scope;
  for (int i = 0; i < 100; ++i) {
    device.read(i * kMs, sample);
    device.set_arm(static_cast<ArmKind>(1 + i % 4));
    device.set_seed(static_cast<std::uint64_t>(i));
    if (i % 7 == 0) device.play(motion.track(), 2);
    if (i % 11 == 0) device.stop_gesture();
    if (i % 31 == 0) device.place(Pose{});
  }
  const std::int64_t touched = scope.count();
  CHECK(touched == 0);
}

TEST_CASE("the same seed, gesture and commands give the same bits, another seed others") {
  const GestureMotion motion = swing();
  const auto run = [&](std::uint64_t seed) {
    auto device = std::make_unique<SimulatedDevice>(usual(), SimulatedOptions{.seed = seed});
    DeviceSample sample;
    for (int i = 0; i < 1000; ++i) {
      device->read(i * kMs, sample);
      if (i == 10) device->play(motion.track(), 0);
      DeviceCommand command{.enable = true};
      command.f_H_D = {-10 * sample.p_DH[0], 0.0, -10 * sample.p_DH[2]};
      device->write(i * kMs, command);
    }
    return device->plant();
  };
  const PlantState first = run(1);
  CHECK(same(first, run(1)));
  CHECK(!same(first, run(2)));
}

TEST_CASE("how often it is read changes nothing in what happens") {
  const GestureMotion motion = swing();
  const auto run = [&](std::int64_t period_ns) {
    SimulatedDevice device(usual(), {});
    DeviceSample sample;
    device.read(0, sample);
    device.play(motion.track(), 1);
    device.write(0, {.f_H_D = {1.0, 0.0, 0.0}, .enable = true});
    for (std::int64_t t_ns = period_ns; t_ns <= 600 * kMs; t_ns += period_ns) {
      device.read(t_ns, sample);
    }
    return device.plant();
  };
  const PlantState usual_rate = run(kMs);
  CHECK(same(usual_rate, run(100'000)));
  CHECK(same(usual_rate, run(60 * kMs)));
  CHECK(same(usual_rate, run(75'000)));
}

TEST_CASE("samples come at the profile's rate, however often it is read") {
  for (const double rate : {1000.0, 500.0, 4000.0}) {
    for (const std::int64_t period_ns : {100'000, 250'000, 1'000'000}) {
      DeviceProfile profile = usual();
      profile.report_rate = rate;
      SimulatedDevice device(profile, {});
      DeviceSample sample;
      int fresh = 0;
      for (std::int64_t t_ns = 0; t_ns < 1'000 * kMs; t_ns += period_ns) {
        if (device.read(t_ns, sample) == ReadOutcome::kFresh) ++fresh;
      }
      CHECK(std::abs(fresh - std::min(rate, 1e9 / static_cast<double>(period_ns))) <= 2);
    }
  }
}

TEST_CASE("a reader whose ticks jitter by less than half a period misses no sample") {
  SimulatedDevice device(usual(), {});
  DeviceSample sample;
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t jitter_ns = (i * 7919) % 800'000 - 400'000;
    REQUIRE(device.read(kMs + i * kMs + (i == 0 ? 0 : jitter_ns), sample) == ReadOutcome::kFresh);
  }
}

TEST_CASE("a pause longer than a tenth of a second is left out, not caught up with") {
  SimulatedOptions options{.arm = ArmKind::kOff};
  SimulatedDevice device(usual(), options);
  DeviceSample sample;
  device.read(0, sample);
  CHECK(device.read(3'600'000'000'000, sample) == ReadOutcome::kFresh);
  CHECK(sample.t_ns <= 3'600'000'000'000);
  CHECK(sample.t_ns > 3'600'000'000'000 - kPlantStep_ns);
}

TEST_CASE("a handle that flies through a pause of a minute gets as far as in a tenth of a second") {
  DeviceProfile profile = usual();
  profile.damping = 0.0;
  profile.coulomb_friction = {};
  SimulatedDevice device(profile, {.arm = ArmKind::kOff});
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, {.f_H_D = {1.0, 0.0, 0.0}, .enable = true});
  device.read(20 * kMs, sample);
  device.write(20 * kMs, {});
  device.read(60 * kMs, sample);
  const PlantState before = device.plant();
  device.read(60'060 * kMs, sample);
  const double way = (device.plant().X_DH.p - before.X_DH.p).norm();
  CHECK(std::abs(way / (0.1 * before.V_DH.v.norm()) - 1.0) < 1e-3);
}

TEST_CASE("a hand that takes the handle in the middle of a gesture ends it and stays there") {
  const GestureMotion motion = swing();
  SimulatedDevice device(usual(), {.arm = ArmKind::kOff});
  DeviceSample sample;
  device.read(0, sample);
  device.play(motion.track(), 0);
  for (int i = 1; i <= 280; ++i) device.read(i * kMs, sample);
  CHECK(device.gesture().playing);
  CHECK(device.plant().X_DH.p.norm() == 0.0);
  device.set_arm(ArmKind::kFirm);
  CHECK(!device.gesture().playing);
  for (int i = 281; i <= 600; ++i) {
    device.read(i * kMs, sample);
    REQUIRE(device.plant().X_DH.p.norm() < 1e-3);
  }
}

TEST_CASE("a hand that closes around a drifting handle holds it where it is") {
  DeviceProfile profile = usual();
  SimulatedDevice device(profile, {.arm = ArmKind::kOff});
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, {.f_H_D = {2.0, 0.0, 0.0}, .t_H_D = {0.0, 0.01, 0.0}, .enable = true});
  for (int i = 1; i <= 100; ++i) device.read(i * kMs, sample);
  device.write(100 * kMs, {});
  device.read(105 * kMs, sample);
  const PlantState there = device.plant();
  CHECK(there.X_DH.p.x() > 0.01);
  device.set_arm(ArmKind::kFirm);
  for (int i = 106; i <= 1500; ++i) device.read(i * kMs, sample);
  // Tremor and friction keep it within a millimetre of where it was caught.
  CHECK((device.plant().X_DH.p - there.X_DH.p).norm() < 1e-3 + there.V_DH.v.norm() * 0.03);
  CHECK(device.plant().V_DH.v.norm() < 0.05);
}

TEST_CASE("placed somewhere, the handle rests there and the gesture is over") {
  const GestureMotion motion = swing();
  SimulatedDevice device(usual(), {});
  DeviceSample sample;
  device.read(0, sample);
  device.play(motion.track(), 0);
  for (int i = 1; i <= 250; ++i) device.read(i * kMs, sample);
  const Pose X_DH{exp_rotation({0.0, 1.0, 0.0}), {0.3, 0.2, 0.1}};
  device.place(X_DH);
  CHECK(!device.gesture().playing);
  CHECK(device.plant().V_DH.v == Vector3::Zero());
  for (int i = 251; i <= 600; ++i) device.read(i * kMs, sample);
  CHECK((device.plant().X_DH.p - X_DH.p).norm() < 5e-4);
}

TEST_CASE("the delay measured from the echo is the one the plant has") {
  for (const double delay : {0.0, 5e-4, 1e-3, 3e-3, 20e-3}) {
    CAPTURE(delay);
    DeviceProfile profile = usual();
    profile.delay = delay;
    SimulatedDevice device(profile, {});
    DeviceSample sample;
    CHECK(std::isnan(sample.measured_delay_s));
    for (int tick = 0; tick < 600; ++tick) {
      device.read(tick * kMs, sample);
      // Nothing is known before the first block of samples is complete.
      if (tick < 250) CHECK(std::isnan(sample.measured_delay_s));
      device.write(tick * kMs, {.sample_counter = sample.counter, .enable = true});
    }
    CHECK(sample.measured_delay_s == within(delay, 1e-12));
  }
}

TEST_CASE(
    "a loop that answers late has the longer delay measured, one that jitters the worst of it") {
  SplitMix64 random(5);
  SimulatedDevice late(usual(), {});
  SimulatedDevice jittering(usual(), {});
  DeviceSample sample;
  DeviceSample other;
  for (int tick = 0; tick < 1200; ++tick) {
    late.read(tick * kMs, sample);
    late.write(tick * kMs + 400'000, {.sample_counter = sample.counter, .enable = true});
    const std::int64_t now_ns = tick * kMs + static_cast<std::int64_t>(random.uniform(0.0, 2e5));
    jittering.read(now_ns, other);
    jittering.write(now_ns, {.sample_counter = other.counter, .enable = true});
  }
  CHECK(sample.measured_delay_s == within(1.4e-3, 1e-12));
  CHECK(other.measured_delay_s >= 1e-3);
  CHECK(other.measured_delay_s <= 1e-3 + 2e-9 * static_cast<double>(kPlantStep_ns));
}

TEST_CASE("commands that tell no sample are not measured") {
  SimulatedDevice device(usual(), {});
  DeviceSample sample;
  for (int tick = 0; tick < 600; ++tick) {
    device.read(tick * kMs, sample);
    device.write(tick * kMs, {.enable = true});
  }
  CHECK(std::isnan(sample.measured_delay_s));
}

TEST_CASE("a number that is no arm holds nothing: the same bits as with the arm off") {
  for (int number = 0; number < 256; ++number) {
    const auto kind = static_cast<ArmKind>(number);
    if (number >= 1 && number <= static_cast<int>(kArmKinds)) continue;
    SimulatedDevice none(usual(), {.arm = ArmKind::kOff});
    SimulatedDevice built(usual(), {.arm = kind});
    SimulatedDevice changed(usual(), {.arm = ArmKind::kFirm});
    changed.set_arm(kind);
    CHECK(changed.arm() == ArmKind::kOff);
    DeviceCommand push;
    push.enable = true;
    push.f_H_D = {1.0, -0.5, 0.2};
    for (std::int64_t ms = 1; ms < 30; ++ms) {
      push.expires_ns = (ms + 50) * kMs;
      for (SimulatedDevice* device : {&none, &built, &changed}) {
        DeviceSample sample;
        device->read(ms * kMs, sample);
        device->write(ms * kMs, push);
      }
    }
    CHECK(same(none.plant(), built.plant()));
    CHECK(std::isfinite(changed.plant().X_DH.p.norm()));
  }
}

TEST_CASE("a plant whose numbers have gone stays so until it is told to recover, and then plays") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double huge = std::numeric_limits<double>::max();
  const GestureMotion motion = swing();
  for (const double bad : {nan, huge, -std::numeric_limits<double>::infinity(), 1e9}) {
    CAPTURE(bad);
    const Pose begin{Quaternion::Identity(), Vector3(0.01, 0.02, -0.03)};
    SimulatedDevice device(usual(), {.X_DH = begin, .arm = ArmKind::kFirm});
    CHECK_FALSE(device.recover());
    DeviceSample sample;
    std::int64_t ms = 1;
    // The target is put there by a leg without duration.
    GestureMotion there;
    there.legs = {{{{0.01, 0.02, -0.03}, {1.0, 0.0, 0.0, 0.0}}, 0, 0, false},
                  {{{bad, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0, 0, true},
                  {{{bad, bad, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0, 0, true}};
    device.play(there.track(), 1);
    const auto usable = [&] {
      return std::isfinite(sample.p_DH[0]) && std::abs(sample.p_DH[0]) <= 1e7;
    };
    for (; ms < 3000 && (ms < 50 || usable()); ++ms) device.read(ms * kMs, sample);
    REQUIRE_FALSE(usable());
    device.set_arm(ArmKind::kLight);
    for (const std::int64_t end = ms + 50; ms < end; ++ms) device.read(ms * kMs, sample);
    REQUIRE_FALSE(usable());
    REQUIRE(device.recover());
    for (const std::int64_t end = ms + 5; ms < end; ++ms) {
      device.read(ms * kMs, sample);
      CHECK(std::abs(sample.p_DH[0] - 0.01) < 1e-3);
      CHECK(std::abs(sample.v_DH_D[0]) < 1.0);
    }
    device.play(motion.track(), 1);
    double farthest = 0.0;
    for (const std::int64_t end = ms + 2000; ms < end; ++ms) {
      device.read(ms * kMs, sample);
      REQUIRE(usable());
      farthest = std::max(farthest, sample.p_DH[0]);
    }
    CHECK(farthest > 0.08);
    CHECK_FALSE(device.recover());
  }
}

}  // namespace hapticd::test
