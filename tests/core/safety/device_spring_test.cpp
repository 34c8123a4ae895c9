// What a device may render by itself, against the laws it must keep: random springs and random ways
// of the hand within its speed, the force computed in long double; eigenvalues by Eigen's solver.
#include "core/safety/device_spring.h"

#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/core/safety/hostile.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using Real3 = std::array<long double, 3>;

/// K way.
Real3 pull(const std::array<double, 6>& K, const Array3& way) {
  const auto& [xx, yy, zz, xy, xz, yz] = K;
  const long double x = way[0];
  const long double y = way[1];
  const long double z = way[2];
  return {xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z};
}

long double length(const Real3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

double least_eigenvalue(const std::array<double, 6>& K) {
  Eigen::Matrix3d matrix;
  matrix << K[0], K[3], K[4], K[3], K[1], K[5], K[4], K[5], K[2];
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix).eigenvalues()[0];
}

/// Symmetric and positive semidefinite: a sum of dyads.
std::array<double, 6> random_stiffness(SplitMix64& random, double scale, int dyads = 3) {
  std::array<double, 6> K{};
  for (int k = 0; k < dyads; ++k) {
    const Array3 n = random.direction();
    const double size = scale * random.uniform();
    const std::array<double, 6> dyad{n[0] * n[0], n[1] * n[1], n[2] * n[2],
                                     n[0] * n[1], n[0] * n[2], n[1] * n[2]};
    for (std::size_t i = 0; i < 6; ++i) K[i] += size * dyad[i];
  }
  return K;
}

SpringContext pressing() {
  SpringContext context;
  context.written.f_H_D = {0.0, 2.0, 0.0};
  context.written.t_H_D = {0.0, 0.0, 0.05};
  context.written.enable = true;
  context.gain = 1.0;
  context.horizon_s = 3e-3;
  context.peak = {9.0, 0.3};
  context.stiffness_max = 3000.0;
  return context;
}

constexpr DeviceSpring kSoft{{100.0, 500.0, 100.0, 10.0, 0.0, -20.0}, {0.5, 0.5, 1.0}};

double wild_or_no_number(SplitMix64& random, double scale) {
  return random.chance(0.02) ? no_number(random) : wild(random, scale);
}

/// Any symmetric one, or one, two or three dyads, and now and then one too many, taken away.
std::array<double, 6> random_spring(SplitMix64& random) {
  const double size = std::exp2(random.uniform(-20.0, 20.0));
  const std::uint64_t kind = random.below(4);
  if (kind == 0) {
    std::array<double, 6> K{};
    for (std::size_t i = 0; i < 6; ++i) {
      K[i] = size * (i < 3 ? random.uniform() : random.uniform(-1.0, 1.0));
    }
    return K;
  }
  std::array<double, 6> K = random_stiffness(random, size, static_cast<int>(kind));
  const double away = random.chance(0.5) ? size * std::exp2(random.uniform(-24.0, -16.0)) : 0.0;
  const std::array<double, 6> less = random_stiffness(random, 1.0, 1);
  for (std::size_t i = 0; i < 6; ++i) K[i] -= away * less[i];
  return K;
}

/// Laws that a granted spring breaks, whatever was asked for.
int wrongs_of(const DeviceSpring& granted, double stiffness_max) {
  int wrong = 0;
  for (std::size_t i = 0; i < 6; ++i) wrong += std::isfinite(granted.K_D[i]) ? 0 : 1;
  for (std::size_t i = 0; i < 3; ++i) {
    wrong += granted.K_D[i] >= 0.0 && granted.Kr_D[i] >= 0.0 ? 0 : 1;
    wrong += std::isfinite(granted.Kr_D[i]) ? 0 : 1;
  }
  // Nothing is relative among denormals.
  if (!is_none({granted.K_D, {}})) {
    const double largest = *std::max_element(granted.K_D.begin(), granted.K_D.end());
    wrong += least_eigenvalue(granted.K_D) >= -1.1e-6 * largest - 1e-300 ? 0 : 1;
  }
  const double bound = row_bound(granted.K_D);
  wrong += bound == 0.0 || bound <= stiffness_max * (1.0 + 1e-12) + 1e-300 ? 0 : 1;
  return wrong;
}

}  // namespace

TEST_CASE("a hand at rest is granted all that the device bears") {
  const DeviceSpring granted = grant_spring(kSoft, pressing());
  CHECK(granted.K_D == kSoft.K_D);
  CHECK(granted.Kr_D == kSoft.Kr_D);
}

TEST_CASE("within the horizon the spring neither turns a force round nor takes it past a limit") {
  SplitMix64 random(1);
  std::int64_t wrong = 0;
  std::int64_t cut = 0;
  for (std::int64_t k = 0; k < scaled(1'000'000); ++k) {
    SpringContext context = pressing();
    context.horizon_s = random.uniform(1e-4, 0.02);
    context.stiffness_max = random.uniform(100.0, 5000.0);
    const Array3 n = random.direction();
    const double size = random.uniform(0.0, context.peak.force);
    for (std::size_t i = 0; i < 3; ++i) context.written.f_H_D[i] = size * n[i];
    context.V_DH_D.v = to_vector(random.direction()) * random.uniform(0.0, 3.0);
    const double speed = context.V_DH_D.v.norm();
    const DeviceSpring wanted{random_stiffness(random, 4000.0), {}};
    const DeviceSpring granted = grant_spring(wanted, context);
    cut += granted.K_D == wanted.K_D ? 0 : 1;
    Array3 way = random.direction();
    for (double& part : way) part *= speed * context.horizon_s * random.uniform();
    const Real3 change = pull(granted.K_D, way);
    Real3 after{};
    long double turned = 0.0L;
    for (std::size_t i = 0; i < 3; ++i) {
      after[i] = context.written.f_H_D[i] - change[i];
      turned += after[i] * context.written.f_H_D[i];
    }
    const long double slack = 1e-12L;
    wrong += turned >= -slack && length(after) <= context.peak.force + slack &&
                     length(change) <= kForceSlew * context.horizon_s + slack &&
                     row_bound(granted.K_D) <= context.stiffness_max * (1.0 + 1e-12)
                 ? 0
                 : 1;
  }
  CHECK(wrong == 0);
  CHECK(cut > 0);
}

TEST_CASE("torque keeps the same laws, by the turning of the hand") {
  SpringContext context = pressing();
  context.V_DH_D.w = {0.0, 0.0, 10.0};
  const DeviceSpring wanted{{}, {2.0, 1.0, 4.0}};
  // 4 N m/rad over 10 rad/s and 3 ms are 0.12 N m, and there are 0.05.
  const DeviceSpring granted = grant_spring(wanted, context);
  CHECK(granted.Kr_D[2] == doctest::Approx(4.0 * 0.05 / 0.12));
  CHECK(granted.Kr_D[0] == doctest::Approx(2.0 * 0.05 / 0.12));
}

TEST_CASE("no spring is granted on a wrench that is off, fading in, limited or nothing") {
  CHECK_FALSE(is_none(grant_spring(kSoft, pressing())));
  SpringContext off = pressing();
  off.written.enable = false;
  CHECK(is_none(grant_spring(kSoft, off)));
  SpringContext fading = pressing();
  fading.gain = 0.999;
  CHECK(is_none(grant_spring(kSoft, fading)));
  for (unsigned bit = 0; bit < 5; ++bit) {
    SpringContext limited = pressing();
    limited.written.flags = 1U << bit;
    CHECK(is_none(grant_spring(kSoft, limited)));
  }
  SpringContext free = pressing();
  free.written.f_H_D = free.written.t_H_D = {};
  CHECK(is_none(grant_spring(kSoft, free)));
}

TEST_CASE("a spring that pushes along some way is not granted, one along a single direction is") {
  SplitMix64 random(3);
  std::int64_t granted_count = 0;
  std::int64_t refused = 0;
  const std::int64_t count = scaled(1'000'000);
  const auto judge = [&](const std::array<double, 6>& K) {
    const double least = least_eigenvalue(K);
    double largest = 0.0;
    for (const double entry : K) largest = std::max(largest, std::abs(entry));
    const bool granted = !is_none(grant_spring({K, {}}, pressing()));
    granted_count += granted ? 1 : 0;
    refused += granted ? 0 : 1;
    // Between the two either is right: the tolerance is 1e-6, rounding far below it.
    if (granted && least < -1.1e-6 * largest) FAIL("granted with " << least << " N/m");
    if (!granted && least >= -0.9e-6 * largest && K[0] >= 0.0 && K[1] >= 0.0 && K[2] >= 0.0) {
      FAIL("refused with " << least << " of " << largest << " N/m");
    }
  };
  for (std::int64_t k = 0; k < count; ++k) {
    const std::array<double, 6> K = random_spring(random);
    if (is_none({K, {}})) continue;
    judge(K);
  }
  CHECK(granted_count > count / 4);
  CHECK(refused > count / 20);
  for (std::size_t beside = 3; beside < 6; ++beside) {
    std::array<double, 6> K{};
    K[beside] = 1000.0;
    CHECK(is_none(grant_spring({K, {}}, pressing())));
  }
  CHECK(is_none(grant_spring({{100, 100, 100, -60, -60, -60}, {}}, pressing())));
  CHECK_FALSE(is_none(grant_spring({{1e9, 0, 0, 0, 0, 0}, {}}, pressing())));
}

TEST_CASE("whatever is asked for, what is granted is finite and pulls along no axis") {
  SplitMix64 random(2);
  std::int64_t wrong = 0;
  for (std::int64_t k = 0; k < scaled(10'000'000); ++k) {
    SpringContext context = pressing();
    DeviceSpring wanted;
    for (double& entry : wanted.K_D) entry = wild_or_no_number(random, 1000.0);
    for (double& entry : wanted.Kr_D) entry = wild_or_no_number(random, 1.0);
    for (double& entry : context.written.f_H_D) entry = wild_or_no_number(random, 2.0);
    context.V_DH_D.v.x() = wild_or_no_number(random, 1.0);
    context.horizon_s = wild_or_no_number(random, 1e-3);
    context.stiffness_max = wild_or_no_number(random, 3000.0);
    context.gain = wild_or_no_number(random, 2.0);
    const DeviceSpring granted = grant_spring(wanted, context);
    wrong += wrongs_of(granted, context.stiffness_max);
  }
  CHECK(wrong == 0);
}

}  // namespace hapticd::test
