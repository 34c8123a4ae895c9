// Which K of an affine command a device takes. Truth: eigenvalues by Eigen's solver, which neither
// the firmware nor the driver knows of, and the motors' force along random displacements.
#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/device/hid/firmware_bench.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using Entries = std::array<std::int16_t, 6>;

/// What PROFILE.md leaves to rounding, N/m.
constexpr double kRounding = 2.0;

Eigen::Matrix3d matrix_of(const Entries& k) {
  Eigen::Matrix3d K;
  K << k[0], k[3], k[4], k[3], k[1], k[5], k[4], k[5], k[2];
  return K;
}

double least_eigenvalue(const Entries& k) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix_of(k)).eigenvalues()[0];
}

Entries rounded(const Eigen::Matrix3d& K) {
  const auto whole = [&](int row, int column) {
    return static_cast<std::int16_t>(std::lround(K(row, column)));
  };
  return {whole(0, 0), whole(1, 1), whole(2, 2), whole(0, 1), whole(0, 2), whole(1, 2)};
}

Eigen::Vector3d direction(SplitMix64& random) {
  const auto n = random.direction();
  return {n[0], n[1], n[2]};
}

/// Eigenvalues `lambda` along a random frame.
Eigen::Matrix3d with_eigenvalues(SplitMix64& random, const Eigen::Vector3d& lambda) {
  const Eigen::Vector3d x = direction(random);
  const Eigen::Vector3d y = x.unitOrthogonal();
  const Eigen::Vector3d z = x.cross(y);
  const double turn = random.uniform(0.0, 6.28);
  const Eigen::Vector3d u = std::cos(turn) * y + std::sin(turn) * z;
  const Eigen::Vector3d v = x.cross(u);
  return lambda[0] * x * x.transpose() + lambda[1] * u * u.transpose() +
         lambda[2] * v * v.transpose();
}

/// A device that takes any row sum, enabled, and its force on a displacement.
class Device {
 public:
  Device() : bench_(settings()) { REQUIRE(bench_.enable()); }

  bool takes(const Entries& k) {
    hid::AffineReport affine{.base = {.flags = hid::kCommandEnable}};
    bench_.sensors.pos_nm[0] = bench_.sensors.pos_nm[1] = bench_.sensors.pos_nm[2] = 0;
    bench_.servo();
    affine.base.ref_seq = bench_.state().seq;
    affine.k_npm = k;
    return bench_.send(affine);
  }
  /// Force times way after that, N m, for a way in m; within the peak.
  double work_along(const Eigen::Vector3d& way) {
    for (int i = 0; i < 3; ++i) bench_.sensors.pos_nm[i] = static_cast<std::int32_t>(1e9 * way[i]);
    const HapOutput output = bench_.servo();
    double work = 0.0;
    for (int i = 0; i < 3; ++i) work += 1e-6 * output.force_un[i] * way[i];
    return work;
  }

 private:
  static HapSettings settings() {
    HapSettings made = settings_with(hid::kCanAffine);
    made.affine_k_max_npm = 200'000;
    return made;
  }
  Bench bench_;
};

TEST_CASE("a K that pushes along a displacement is refused, whichever minor tells") {
  Device device;
  CHECK(device.takes({0, 0, 0, 0, 0, 0}));
  CHECK(device.takes({500, 500, 800, 0, -100, 0}));
  // Leading minors of these are zero: one plane each, and a diagonal that tells nothing.
  CHECK_FALSE(device.takes({0, 0, 0, 1000, 0, 0}));
  CHECK_FALSE(device.takes({0, 0, 0, 0, 1000, 0}));
  CHECK_FALSE(device.takes({0, 0, 0, 0, 0, 1000}));
  CHECK_FALSE(device.takes({0, 500, 500, 0, 0, -600}));
  CHECK_FALSE(device.takes({500, 0, 500, 0, 510, 0}));
  CHECK_FALSE(device.takes({100, 100, 0, 100, 0, 50}));
  // Every plane is sound, all three together are not.
  CHECK_FALSE(device.takes({100, 100, 100, -60, -60, -60}));
  CHECK_FALSE(device.takes({32767, 32767, 32767, -32768, -32768, -32768}));
  CHECK(device.takes({32767, 32767, 32767, 32767, 32767, 32767}));
  CHECK_FALSE(device.takes({-1, 100, 100, 0, 0, 0}));
}

TEST_CASE("over a cloud of K, the device takes those whose eigenvalues allow it, and no others") {
  SplitMix64 random(21);
  Device device;
  std::int64_t taken = 0;
  std::int64_t refused = 0;
  const std::int64_t count = scaled(1'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    const double size = std::exp2(random.uniform(0.0, 14.9));
    Entries k{};
    if (random.chance(0.5)) {
      for (std::int16_t& entry : k) {
        entry = static_cast<std::int16_t>(std::lround(random.uniform(-size, size)));
      }
      for (std::size_t j = 0; j < 3; ++j) k[j] = static_cast<std::int16_t>(std::abs(int{k[j]}));
    } else {
      // About the edge: the least eigenvalue within some newtons per metre of it.
      const Eigen::Vector3d lambda{random.uniform(-6.0, 3.0), random.uniform(0.0, size),
                                   random.uniform(0.0, size)};
      k = rounded(with_eigenvalues(random, lambda));
      if (*std::min_element(k.begin(), k.begin() + 3) < 0) continue;
    }
    const double least = least_eigenvalue(k);
    // Whole numbers are exact in the device, eigenvalues here to some 1e-11.
    if (std::abs(least + kRounding) < 1e-9 * (1.0 + size)) continue;
    const bool took = device.takes(k);
    taken += took ? 1 : 0;
    refused += took ? 0 : 1;
    if (took != (least > -kRounding)) FAIL("K number " << i << ", least eigenvalue " << least);
    if (!took) continue;
    const Eigen::Vector3d way = 1e-4 * direction(random);
    // By the rounding, and by the motors' whole micronewtons.
    REQUIRE(device.work_along(way) <= (kRounding * way.norm() + 4e-6) * way.norm());
  }
  CHECK(taken > count / 20);
  CHECK(refused > count / 20);
}

TEST_CASE("springs along one, two or three directions, rounded to whole N/m, are all taken") {
  SplitMix64 random(22);
  Device device;
  for (std::int64_t i = 0; i < scaled(1'000'000); ++i) {
    const double size = std::exp2(random.uniform(-2.0, 14.9));
    const std::uint64_t rank = 1 + random.below(3);
    Eigen::Vector3d lambda = Eigen::Vector3d::Zero();
    for (std::uint64_t j = 0; j < rank; ++j) {
      lambda[static_cast<Eigen::Index>(j)] = size * random.uniform();
    }
    const Entries k = rounded(with_eigenvalues(random, lambda));
    if (!device.takes(k)) FAIL("spring number " << i << " of rank " << rank);
  }
}

}  // namespace
}  // namespace hapticd::test
