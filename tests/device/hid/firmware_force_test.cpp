// What the reference firmware gives to its motors: limits, axes, grip, brake, and the affine
// command against the formula of PROFILE.md, section 4, computed in long double.
#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/device/hid/firmware_bench.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using hid::kCommandEnable;
using Real = long double;
using Real3 = std::array<Real, 3>;
using Int3 = std::array<std::int32_t, 3>;

constexpr Real kPeakForce_un = 9e6L;
constexpr Real kPeakTorque_unm = 3e5L;
/// Up to three divisions of whole numbers per axis lose less than 1 each, sqrt(27) together, and
/// the root another 1: uN or uN m.
constexpr Real kWholeNumbers = 6.2L;

Real norm(const Real3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

Real3 real(const std::int32_t (&v)[3]) { return {Real(v[0]), Real(v[1]), Real(v[2])}; }

/// `v` shortened along its direction.
Real3 shortened(Real3 v, Real most) {
  const Real length = norm(v);
  if (length <= most) return v;
  for (Real& component : v) component *= most / length;
  return v;
}

Real distance(const Real3& a, const Real3& b) {
  return norm({a[0] - b[0], a[1] - b[1], a[2] - b[2]});
}

Int3 random_wrench(SplitMix64& random, std::uint64_t reach) {
  Int3 v{};
  for (std::int32_t& component : v) {
    component = static_cast<std::int32_t>(static_cast<std::int64_t>(random.below(2 * reach + 1)) -
                                          static_cast<std::int64_t>(reach));
  }
  return v;
}

TEST_CASE("force and torque are shortened along their direction, and left alone within limits") {
  SplitMix64 random(4);
  Bench bench;
  REQUIRE(bench.enable());
  std::int64_t wrong = 0;
  std::int64_t cut = 0;
  for (std::int64_t k = 0; k < scaled(200'000); ++k) {
    const std::uint64_t reach = std::uint64_t{1} << random.below(32);
    hid::CommandReport command{.flags = kCommandEnable};
    command.force_un = random_wrench(random, std::min<std::uint64_t>(reach, INT32_MAX));
    command.torque_unm = random_wrench(random, std::min<std::uint64_t>(reach / 16, INT32_MAX));
    if (random.chance(0.01)) command.force_un[0] = INT32_MIN;
    bench.send(command);
    const HapOutput output = bench.servo();
    Real3 force{};
    Real3 torque{};
    for (std::size_t i = 0; i < 3; ++i) {
      force[i] = command.force_un[i];
      torque[i] = command.torque_unm[i];
    }
    const bool beyond = norm(force) > kPeakForce_un || norm(torque) > kPeakTorque_unm;
    cut += beyond ? 1 : 0;
    wrong += norm(real(output.force_un)) <= kPeakForce_un ? 0 : 1;
    wrong += norm(real(output.torque_unm)) <= kPeakTorque_unm ? 0 : 1;
    const Real tolerance = beyond ? kWholeNumbers : 0.0L;
    wrong += distance(real(output.force_un), shortened(force, kPeakForce_un)) <= tolerance ? 0 : 1;
    wrong +=
        distance(real(output.torque_unm), shortened(torque, kPeakTorque_unm)) <= tolerance ? 0 : 1;
    wrong += bench.device.saturated == beyond ? 0 : 1;
  }
  CHECK(wrong == 0);
  CHECK(cut > 0);
}

TEST_CASE("the caps of Config hold when they are below the peak, and zero means none") {
  Bench bench;
  bench.send(kConfig);  // 4 N, 0.15 N m
  REQUIRE(bench.enable());
  hid::CommandReport command{
      .flags = kCommandEnable, .force_un = {0, -8'000'000, 0}, .torque_unm = {0, 0, 200'000}};
  bench.send(command);
  HapOutput output = bench.servo();
  CHECK(output.force_un[1] == -4'000'000);
  CHECK(output.torque_unm[2] == 150'000);
  CHECK(bench.shows(hid::kStatusSaturated));
  hid::Config more = kConfig;
  more.f_cap_cn = more.tau_cap_mnm = 65'535;
  bench.send_flags(0);
  bench.servo();
  bench.send(more);
  CHECK(bench.config().f_cap_cn == 900);
  CHECK(bench.config().tau_cap_mnm == 300);
  bench.send_flags(kCommandEnable);
  bench.send(command);
  hid::Config none = kConfig;
  none.f_cap_cn = none.tau_cap_mnm = 0;
  bench.send(none);
  output = bench.servo();
  CHECK(output.force_un[1] == 0);
  CHECK(output.torque_unm[2] == 0);
  CHECK_FALSE(bench.shows(hid::kStatusActive));
}

TEST_CASE("axes that are not driven get nothing and do not count for the limit") {
  HapSettings settings = settings_with(0);
  settings.capabilities.dof = 0x0040 | 0x0400;  // force along x, torque about y
  Bench bench(settings);
  REQUIRE(bench.enable());
  bench.send(hid::CommandReport{.flags = kCommandEnable,
                                .force_un = {8'000'000, 8'000'000, 8'000'000},
                                .torque_unm = {200'000, 200'000, 200'000}});
  const HapOutput output = bench.servo();
  CHECK(real(output.force_un) == Real3{8e6L, 0, 0});
  CHECK(real(output.torque_unm) == Real3{0, 2e5L, 0});
  CHECK_FALSE(bench.shows(hid::kStatusSaturated));
}

TEST_CASE("the grip pushes with GRIP alone, where there is one, and within its peak") {
  HapSettings settings = settings_with(0);
  const auto grip = [&settings](unsigned flags, int force_mn) {
    Bench bench(settings);
    REQUIRE(bench.enable());
    bench.send(hid::CommandReport{.flags = static_cast<std::uint8_t>(flags | kCommandEnable),
                                  .grip_mn = static_cast<std::int16_t>(force_mn)});
    return bench.servo().grip_mn;
  };
  CHECK(grip(hid::kCommandGrip, 1500) == 1500);
  CHECK(grip(0, 1500) == 0);
  CHECK(grip(hid::kCommandGrip, 2001) == 2000);
  CHECK(grip(hid::kCommandGrip, INT16_MIN) == -2000);
  settings.grip_peak_mn = 65'535;
  CHECK(grip(hid::kCommandGrip, INT16_MAX) == INT16_MAX);
  settings.capabilities.dof = 0x1FFF;
  CHECK(grip(hid::kCommandGrip, 1500) == 0);
}

TEST_CASE("BRAKE leaves no force, and closes the brake where there is one") {
  for (const std::uint32_t caps : {std::uint32_t{0}, hid::kHasBrake}) {
    Bench bench(caps);
    const hid::CommandReport command{.flags = kCommandEnable | hid::kCommandBrake,
                                     .force_un = {5, 5, 5},
                                     .torque_unm = {5, 5, 5}};
    bench.send(command);
    CHECK(is_zero(bench.servo()));
    REQUIRE(bench.enable());
    bench.send(command);
    const HapOutput output = bench.servo();
    CHECK(output.brake == (caps != 0));
    CHECK(real(output.force_un) == Real3{});
    CHECK(real(output.torque_unm) == Real3{});
  }
}

TEST_CASE("gravity is carried when Config asks for it, where that is possible, and enabled only") {
  for (const std::uint32_t caps : {std::uint32_t{0}, hid::kCanGravity}) {
    Bench bench(caps);
    hid::Config config = kConfig;
    config.grav_comp = 7;
    bench.send(config);
    CHECK(bench.config().grav_comp == (caps != 0 ? 1 : 0));
    CHECK_FALSE(bench.servo().gravity);
    REQUIRE(bench.enable());
    CHECK(bench.servo().gravity == (caps != 0));
  }
}

/// A random measurement: some centimetres and radians, any orientation.
void move(SplitMix64& random, HapMeasurement& sensors) {
  const Int3 pos = random_wrench(random, 100'000'000);
  const Int3 vel = random_wrench(random, 32'767);
  const Int3 avel = random_wrench(random, 32'767);
  for (std::size_t i = 0; i < 3; ++i) {
    sensors.pos_nm[i] = pos[i];
    sensors.vel[i] = static_cast<std::int16_t>(vel[i] / 16);
    sensors.avel[i] = static_cast<std::int16_t>(avel[i] / 4);
  }
  std::array<double, 4> q{};
  double square = 0.0;
  for (double& component : q) {
    component = random.uniform(-1.0, 1.0);
    square += component * component;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    sensors.quat_q30[i] = static_cast<std::int32_t>(q[i] / std::sqrt(square) * (1 << 30));
  }
}

/// t = Kr e, e = 2 s vec(q_ref conj(q)), from the rotation matrix of neither: by the product.
Real3 turn_between(const std::int32_t (&a)[4], const std::int32_t (&b)[4]) {
  const Real one = 1 << 30;
  const Real w0 = a[0] / one, x0 = a[1] / one, y0 = a[2] / one, z0 = a[3] / one;
  const Real w1 = b[0] / one, x1 = -b[1] / one, y1 = -b[2] / one, z1 = -b[3] / one;
  const Real s = w0 * w1 - x0 * x1 - y0 * y1 - z0 * z1 < 0 ? -2 : 2;
  return {s * (w0 * x1 + x0 * w1 + y0 * z1 - z0 * y1), s * (w0 * y1 - x0 * z1 + y0 * w1 + z0 * x1),
          s * (w0 * z1 + x0 * y1 - y0 * x1 + z0 * w1)};
}

TEST_CASE("an affine command gives f0 + K (x_ref - x) - B v on the newest measurement, clamped") {
  SplitMix64 random(5);
  HapSettings settings = settings_with(hid::kCanAffine | hid::kHasVelocity);
  settings.affine_k_max_npm = 100'000;
  Bench bench(settings);
  REQUIRE(bench.enable());
  std::int64_t wrong = 0;
  std::int64_t within = 0;
  for (std::int64_t k = 0; k < scaled(100'000); ++k) {
    move(random, bench.sensors);
    bench.servo();
    const HapMeasurement at = bench.sensors;
    hid::AffineReport affine{.base = {.flags = kCommandEnable, .ref_seq = bench.state().seq}};
    affine.base.force_un = random_wrench(random, 2'000'000);
    affine.base.torque_unm = random_wrench(random, 50'000);
    const Int3 diagonal = random_wrench(random, 300);
    const Int3 beside = random_wrench(random, 30);
    for (std::size_t i = 0; i < 3; ++i) {
      // Above the sum beside it: positive definite.
      affine.k_npm[i] = static_cast<std::int16_t>(60 + std::abs(diagonal[i]));
      affine.k_npm[3 + i] = static_cast<std::int16_t>(beside[i]);
      affine.b_mnspm[i] = static_cast<std::uint16_t>(random.below(3000));
      affine.kr_mnmprad[i] = static_cast<std::uint16_t>(random.below(200));
      affine.br_10unmsprad[i] = static_cast<std::uint16_t>(random.below(200));
    }
    if (!bench.send(affine)) ++wrong;
    move(random, bench.sensors);
    const HapMeasurement& now = bench.sensors;
    const HapOutput output = bench.servo();
    const auto& K = affine.k_npm;
    const std::array<std::array<int, 3>, 3> rows{
        {{K[0], K[3], K[4]}, {K[3], K[1], K[5]}, {K[4], K[5], K[2]}}};
    Real3 force{};
    Real3 torque{};
    const Real3 turn = turn_between(at.quat_q30, now.quat_q30);
    for (std::size_t i = 0; i < 3; ++i) {
      force[i] =
          affine.base.force_un[i] - affine.b_mnspm[i] * Real(now.vel[i]) * 1e-3L * 1e-4L * 1e6L;
      for (std::size_t j = 0; j < 3; ++j) {
        force[i] += rows[i][j] * (Real(at.pos_nm[j]) - now.pos_nm[j]) * 1e-9L * 1e6L;
      }
      torque[i] = affine.base.torque_unm[i] + affine.kr_mnmprad[i] * turn[i] * 1e-3L * 1e6L -
                  affine.br_10unmsprad[i] * Real(now.avel[i]) * 1e-5L * 1e-3L * 1e6L;
    }
    within += norm(force) < kPeakForce_un ? 1 : 0;
    wrong +=
        distance(real(output.force_un), shortened(force, kPeakForce_un)) < kWholeNumbers ? 0 : 1;
    wrong += distance(real(output.torque_unm), shortened(torque, kPeakTorque_unm)) < kWholeNumbers
                 ? 0
                 : 1;
  }
  CHECK(wrong == 0);
  CHECK(within > 0);
}

TEST_CASE("a K is taken exactly when it pushes along no way by more than rounding") {
  SplitMix64 random(fresh_seed());
  HapSettings settings = settings_with(hid::kCanAffine | hid::kHasVelocity);
  settings.affine_k_max_npm = UINT32_MAX;
  Bench bench(settings);
  std::int64_t taken = 0;
  std::int64_t wrong = 0;
  const std::int64_t all = scaled(1'000'000);
  for (std::int64_t k = 0; k < all; ++k) {
    HapAffine affine{};
    const double size = std::pow(10.0, random.uniform(0.0, 4.4));
    Eigen::Matrix3d K = Eigen::Matrix3d::Zero();
    if (random.chance(0.5)) {
      // Hardly stiff along one way or two, or not at all.
      for (std::uint64_t dyads = 1 + random.below(3); dyads > 0; --dyads) {
        const auto u = random.direction();
        const Eigen::Vector3d along(u[0], u[1], u[2]);
        K += size / 3.0 * random.uniform() * along * along.transpose();
      }
      if (random.chance(0.5)) K.diagonal().array() -= random.uniform(0.0, 4.0);
    } else {
      for (Eigen::Index i = 0; i < 9; ++i) K(i) = random.uniform(-size, size);
    }
    const Eigen::Index rows[6] = {0, 1, 2, 0, 0, 1};
    const Eigen::Index columns[6] = {0, 1, 2, 1, 2, 2};
    Eigen::Matrix3d rounded;
    for (std::size_t i = 0; i < 6; ++i) {
      affine.k_npm[i] = static_cast<std::int16_t>(std::lround(K(rows[i], columns[i])));
      rounded(rows[i], columns[i]) = rounded(columns[i], rows[i]) = affine.k_npm[i];
    }
    const double least =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(rounded, Eigen::EigenvaluesOnly)
            .eigenvalues()
            .minCoeff();
    const bool is_taken = hap_affine_is_sound(&bench.device, &affine);
    taken += is_taken ? 1 : 0;
    constexpr double kRounding = 1e-6;
    if (is_taken && least < -2.0 - kRounding) ++wrong;
    if (!is_taken && least > kRounding) ++wrong;
  }
  CHECK(wrong == 0);
  CHECK(taken > all / 100);
  CHECK(taken < all - all / 100);
}

TEST_CASE("gains beyond what the maker states, or this file where he states none, are not taken") {
  SplitMix64 random(fresh_seed());
  for (std::int64_t k = 0; k < scaled(10'000); ++k) {
    HapSettings settings = settings_with(hid::kCanAffine | hid::kHasVelocity);
    const bool stated = random.chance(0.5);
    const auto most = static_cast<std::uint16_t>(stated ? 1 + random.below(65'535) : 0);
    settings.affine_b_max_mnspm = settings.affine_kr_max_mnmprad = most;
    settings.affine_br_max_10unmsprad = most;
    const Bench bench(settings);
    HapAffine affine{};
    const std::size_t axis = random.below(3);
    const auto gain = static_cast<std::uint16_t>(random.below(65'536));
    const std::uint64_t which = random.below(3);
    (which == 0   ? affine.b_mnspm
     : which == 1 ? affine.kr_mnmprad
                  : affine.br_10unmsprad)[axis] = gain;
    const int free = which == 0 ? kHapMostDamping : kHapMostTurnStiffness;
    CHECK(hap_affine_is_sound(&bench.device, &affine) == (gain <= (stated ? most : free)));
  }
}

TEST_CASE("the largest gains and distances overflow nothing") {
  HapSettings settings = settings_with(hid::kCanAffine | hid::kHasVelocity);
  settings.affine_k_max_npm = UINT32_MAX;
  settings.affine_b_max_mnspm = settings.affine_kr_max_mnmprad = UINT16_MAX;
  settings.affine_br_max_10unmsprad = UINT16_MAX;
  for (const bool back : {false, true}) {
    Bench bench(settings);
    bench.sensors.quat_q30[0] = -(1 << 30);
    for (std::int32_t& p : bench.sensors.pos_nm) p = back ? INT32_MAX : INT32_MIN;
    hid::Config config = bench.config();
    config.v_cap_mmps = hid::kNoSpeedCap;
    bench.send(config);
    REQUIRE(bench.enable());
    hid::AffineReport affine{.base = {.flags = kCommandEnable, .ref_seq = bench.state().seq}};
    affine.base.force_un = affine.base.torque_unm = {INT32_MIN, INT32_MIN, INT32_MIN};
    affine.k_npm = {32767, 32767, 32767, 32767, 32767, 32767};
    affine.b_mnspm = affine.kr_mnmprad = affine.br_10unmsprad = {65535, 65535, 65535};
    CHECK(bench.send(affine));
    for (std::size_t i = 0; i < 3; ++i) {
      bench.sensors.pos_nm[i] = back ? INT32_MIN : INT32_MAX;
      bench.sensors.vel[i] = bench.sensors.avel[i] = INT16_MIN;
    }
    for (std::int32_t& q : bench.sensors.quat_q30) q = (1 << 30) + (1 << 16);
    const HapOutput output = bench.servo();
    CHECK(norm(real(output.force_un)) <= kPeakForce_un);
    CHECK(norm(real(output.torque_unm)) <= kPeakTorque_unm);
    // The spring wins: 98301 N/m times 4.29 m along (1, 1, 1).
    const Real along = (back ? kPeakForce_un : -kPeakForce_un) / std::sqrt(3.0L);
    CHECK(distance(real(output.force_un), {along, along, along}) < kWholeNumbers);
    // No quaternion at all is a broken sensor.
    bench.sensors.quat_q30[3] = INT32_MIN;
    CHECK(is_zero(bench.servo()));
    CHECK(bench.state().fault == hid::kFaultEncoder);
  }
}

}  // namespace
}  // namespace hapticd::test
