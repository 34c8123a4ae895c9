// The simulated device against closed forms: delay, lag, saturation, quantisation, arm, energy.
#include <doctest/doctest.h>

#include <cfenv>
#include <cmath>

#include "core/math/rotation.h"
#include "device/simulated/simulated_device.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// No friction, no encoder steps, no lag.
DeviceProfile plain() {
  DeviceProfile profile;
  profile.name = {'p', 'l', 'a', 'i', 'n'};
  profile.peak_force = 22.0;
  profile.peak_torque = 0.5;
  profile.mass = {0.2, 0.2, 0.2};
  profile.damping = 0.0;
  return profile;
}

SimulatedOptions hands_off() { return {.arm = ArmKind::kOff}; }

DeviceCommand push(const Array3& force, const Array3& torque = {}) {
  return {.f_H_D = force, .t_H_D = torque, .enable = true};
}

double relative(double value, double truth) { return std::abs(value - truth) / std::abs(truth); }

}  // namespace

TEST_CASE("a force acts after exactly the declared delay, not a sub-step sooner or later") {
  DeviceProfile profile = plain();
  profile.delay = 3.25e-3;
  SimulatedDevice device(profile, hands_off());
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, push({1.0, 0.0, 0.0}));
  device.read(3'250'000, sample);
  CHECK(device.plant().V_DH.v.x() == 0.0);
  device.read(10 * kMs, sample);
  const double t = 6.75e-3;
  CHECK(relative(device.plant().V_DH.v.x(), 1.0 / 0.2 * t) < 1e-12);
  CHECK(relative(device.plant().X_DH.p.x(), 0.5 / 0.2 * t * t) < 1e-12);
}

TEST_CASE("force builds up with the time constant of the motors, impulse and all") {
  DeviceProfile profile = plain();
  profile.motor_lag = 2e-3;
  SimulatedDevice device(profile, hands_off());
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, push({4.0, 0.0, 0.0}));
  device.read(2 * kMs, sample);
  CHECK(relative(device.plant().F_H_D.f.x(), 4.0 * (1 - std::exp(-1.0))) < 1e-12);
  device.read(6 * kMs, sample);
  const double impulse = 4.0 * (6e-3 + 2e-3 * std::expm1(-3.0));
  CHECK(relative(device.plant().V_DH.v.x(), impulse / 0.2) < 1e-11);
}

TEST_CASE("what dies away ends at rest, and never in numbers that are slow to compute with") {
  ArmModels still = usual_arms();
  for (ArmModel& arm : still) arm.tremor = 0.0;
  for (const ArmKind arm : {ArmKind::kOff, ArmKind::kLight, ArmKind::kFirm}) {
    DeviceProfile profile = plain();
    profile.damping = 5.0;
    profile.rotational_damping = {0.01, 0.01, 0.01};
    profile.motor_lag = 2e-3;
    SimulatedDevice device(profile, {.arm = arm, .arms = still});
    DeviceSample sample;
    device.read(0, sample);
    device.write(0, push({4.0, -3.0, 2.0}, {0.01, 0.02, -0.03}));
    device.read(50 * kMs, sample);
    REQUIRE(device.plant().V_DH.v.norm() > 0.0);
    device.write(50 * kMs, push({}));
    std::feclearexcept(FE_UNDERFLOW);
    for (std::int64_t k = 1; k <= 1200; ++k) device.read((1 + k) * 50 * kMs, sample);
    CHECK(std::fetestexcept(FE_UNDERFLOW) == 0);
    CHECK(device.plant().F_H_D.f == Vector3::Zero());
    CHECK(device.plant().F_H_D.t == Vector3::Zero());
    CHECK(device.plant().V_DH.v == Vector3::Zero());
    CHECK(device.plant().V_DH.w == Vector3::Zero());
  }
}

TEST_CASE("beyond its peak the device gives its peak, in the direction asked, and says so") {
  SimulatedDevice device(plain(), hands_off());
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, push({300.0, 400.0, 0.0}, {0.0, 0.0, -3.0}));
  device.read(kMs, sample);
  CHECK((device.plant().F_H_D.f - Vector3(13.2, 17.6, 0)).norm() < 1e-12);
  CHECK((device.plant().F_H_D.t - Vector3(0, 0, -0.5)).norm() < 1e-14);
  CHECK((sample.flags & kDeviceSaturated) != 0);
  device.write(kMs, push({1.0, 0.0, 0.0}));
  device.read(2 * kMs, sample);
  CHECK((sample.flags & kDeviceSaturated) == 0);
}

TEST_CASE("a device without torque motors gives none") {
  DeviceProfile profile = plain();
  profile.actuated_axes = 3;
  SimulatedDevice device(profile, hands_off());
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, push({0.0, 0.0, 0.0}, {0.1, 0.1, 0.1}));
  device.read(10 * kMs, sample);
  CHECK(device.plant().V_DH.w == Vector3::Zero());
}

TEST_CASE("each axis has its own mass and inertia") {
  DeviceProfile profile = plain();
  profile.mass = {0.1, 0.2, 0.4};
  profile.inertia = {1e-3, 2e-3, 4e-3};
  profile.rotational_damping = {};
  SimulatedDevice device(profile, hands_off());
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, push({1.0, 1.0, 1.0}, {1e-2, 1e-2, 1e-2}));
  device.read(10 * kMs, sample);
  CHECK((device.plant().V_DH.v - Vector3(0.1, 0.05, 0.025)).norm() < 1e-14);
  CHECK((device.plant().V_DH.w - Vector3(0.1, 0.05, 0.025)).norm() < 1e-14);
}

TEST_CASE("a handle that turns about a fixed axis arrives at angular velocity times time") {
  DeviceProfile profile = plain();
  profile.rotational_damping = {};
  SimulatedDevice device(profile, hands_off());
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, push({}, {1e-3, 2e-3, -2e-3}));
  device.read(100 * kMs, sample);
  // Half of torque over inertia times time squared: 0.15 rad.
  const Vector3 phi = 0.5 * 0.01 * Vector3(1e-3, 2e-3, -2e-3) / 1e-4;
  CHECK((log_rotation(device.plant().X_DH.q) - phi).norm() < 1e-12);
}

TEST_CASE("reported positions are multiples of the encoder step, the nearest ones") {
  DeviceProfile profile = plain();
  profile.position_resolution = {2e-5, 3e-5, 5e-5};
  profile.rotation_resolution = {1e-3, 1e-3, 1e-3};
  profile.rotational_damping = {};
  SimulatedDevice device(profile, hands_off());
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, push({0.9, -0.7, 0.5}, {1e-3, 0.0, 0.0}));
  for (int i = 1; i <= 90; ++i) {
    device.read(i * kMs, sample);
    const PlantState truth = device.plant();
    for (std::size_t k = 0; k < 3; ++k) {
      const double step = profile.position_resolution[k];
      const double steps = sample.p_DH[k] / step;
      REQUIRE(std::abs(steps - std::round(steps)) < 1e-9);
      REQUIRE(std::abs(sample.p_DH[k] - truth.X_DH.p[static_cast<Eigen::Index>(k)]) <=
              0.5 * step * (1 + 1e-9));
    }
    const double angle = log_rotation(to_quaternion(sample.q_DH)).x();
    REQUIRE(std::abs(angle / 1e-3 - std::round(angle / 1e-3)) < 1e-9);
    REQUIRE(std::abs(angle - log_rotation(truth.X_DH.q).x()) <= 0.5e-3 * (1 + 1e-9));
    REQUIRE(!sample.has_velocity);
  }
  // The difference of positions is the velocity, to a step per period.
  const double v = device.plant().V_DH.v.x();
  CHECK(std::abs(sample.v_DH_D[0] - v) <= 2e-5 / 1e-3 * 1.2);
}

TEST_CASE("under a force the arm gives way like a mass on a damped spring") {
  DeviceProfile profile = plain();
  profile.damping = 1.0;
  SimulatedOptions options{.arm = ArmKind::kLight};
  ArmModel& arm = options.arms[index_of(ArmKind::kLight)];
  arm = {.mass = 0.1,
         .stiffness = 300.0,
         .damping = 7.0,
         .inertia = 1e-4,
         .rotational_stiffness = 2.0,
         .rotational_damping = 0.02};
  SimulatedDevice device(profile, options);
  DeviceSample sample;
  device.read(0, sample);
  device.write(0, push({0.0, -3.0, 0.0}));
  const double m = 0.3;
  const double decay = 8.0 / (2 * m);
  const double omega = std::sqrt(300.0 / m - decay * decay);
  for (int i = 1; i <= 300; ++i) {
    device.read(i * kMs, sample);
    const double t = i * 1e-3;
    const double y =
        -3.0 / 300.0 *
        (1 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t)));
    REQUIRE(std::abs(device.plant().X_DH.p.y() - y) < 1e-13);
  }
}

TEST_CASE("a light arm carries the handle along a gesture to its end, a hand off leaves it alone") {
  GestureMotion motion;
  motion.legs.resize(2);
  motion.legs[1] = {
      {{0.05, 0.02, -0.01}, to_array(exp_rotation({0.2, 0, 0}))}, 400 * kMs, 0, false};
  for (const ArmKind arm : {ArmKind::kLight, ArmKind::kFirm, ArmKind::kOff}) {
    SimulatedOptions options{.arm = arm};
    for (ArmModel& model : options.arms) model.tremor = 0.0;
    SimulatedDevice device(plain(), options);
    DeviceSample sample;
    device.read(0, sample);
    device.play(motion.track(), 1);
    for (int i = 1; i <= 2000; ++i) device.read(i * kMs, sample);
    const Pose X_DH = device.plant().X_DH;
    const Vector3 end = arm == ArmKind::kOff ? Vector3(0, 0, 0) : Vector3(0.05, 0.02, -0.01);
    CHECK((X_DH.p - end).norm() < 1e-9);
    if (arm != ArmKind::kOff) {
      CHECK((log_rotation(X_DH.q) - Vector3(0.2, 0, 0)).norm() < 1e-9);
      CHECK(device.gesture().finished == 1);
    }
  }
}

TEST_CASE(
    "a turning target drags the handle behind by damping to the ground over stiffness alone") {
  DeviceProfile profile = plain();
  profile.rotational_damping = {4e-3, 4e-3, 4e-3};
  SimulatedOptions options{.arm = ArmKind::kLight};
  ArmModel& arm = options.arms[index_of(ArmKind::kLight)];
  arm = {.stiffness = 300.0,
         .damping = 7.0,
         .inertia = 1e-4,
         .rotational_stiffness = 2.0,
         .rotational_damping = 0.02};
  GestureMotion motion;
  motion.legs.resize(2);
  motion.legs[1] = {{{0, 0, 0}, to_array(exp_rotation({0, 0, 1.5}))}, 1000 * kMs, 0, true};
  SimulatedDevice device(profile, options);
  DeviceSample sample;
  device.read(0, sample);
  device.play(motion.track(), 1);
  for (int i = 1; i <= 800; ++i) device.read(i * kMs, sample);
  const PlantState state = device.plant();
  CHECK(std::abs(state.V_DH.w.z() - 1.5) < 1e-9);
  const Vector3 behind = log_rotation(state.X_DH_target.q * state.X_DH.q.conjugate());
  CHECK(std::abs(behind.z() - 1.5 * 4e-3 / 2.0) < 1e-9);
}

TEST_CASE("the adversarial arm gives back the force it felt, after its delay") {
  for (const double delay : {0.0, 5e-3, 37e-3}) {
    CAPTURE(delay);
    SimulatedOptions options{.arm = ArmKind::kAdversarial};
    options.arms[index_of(ArmKind::kAdversarial)] = {.mass = 0.1, .delay = delay};
    SimulatedDevice device(plain(), options);
    DeviceSample sample;
    device.read(0, sample);
    device.write(0, push({3.0, 0.0, 0.0}));
    device.read(100 * kMs, sample);
    // Its own step of 1 ms, besides.
    const double truth = 3.0 / 0.3 * 0.1 + 3.0 / 0.3 * (0.1 - delay - 1e-3);
    CHECK(std::abs(device.plant().V_DH.v.x() - truth) < 1e-12);
  }
}

TEST_CASE("with the hand off and no command, energy never grows and dry friction ends the motion") {
  SplitMix64 random(21);
  for (std::int64_t i = 0; i < scaled(300); ++i) {
    DeviceProfile profile = plain();
    profile.damping = random.uniform(0.0, 3.0);
    for (std::size_t k = 0; k < 3; ++k) {
      profile.mass[k] = std::pow(10.0, random.uniform(-3.0, 1.0));
      profile.inertia[k] = std::pow(10.0, random.uniform(-6.0, -1.0));
      profile.coulomb_friction[k] = random.uniform(0.1, 1.0);
      profile.coulomb_torque[k] = random.uniform(1e-3, 1e-2);
    }
    SimulatedDevice device(profile, hands_off());
    DeviceSample sample;
    device.read(0, sample);
    const Array3 f = random.direction();
    const Array3 t = random.direction();
    device.write(0, push({5 * f[0], 5 * f[1], 5 * f[2]}, {0.1 * t[0], 0.1 * t[1], 0.1 * t[2]}));
    device.read(20 * kMs, sample);
    device.write(20 * kMs, {});
    device.read(21 * kMs, sample);
    double before = device.plant().energy;
    CHECK(before > 0.0);
    for (int tick = 22; tick < 500; ++tick) {
      device.read(tick * kMs, sample);
      const double after = device.plant().energy;
      REQUIRE(after <= before);
      before = after;
    }
    for (int tick = 5; tick < 300; ++tick) device.read(tick * (100 * kMs), sample);
    CHECK(device.plant().energy == 0.0);
  }
}

}  // namespace hapticd::test
