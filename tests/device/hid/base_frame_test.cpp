// Axis maps of HID devices against matrices: all 48 choices of axes and signs, as M of long double,
// with rotations as M R M^T and angular velocities as M [w] M^T, where no pseudovector is spoken
// of.
#include "device/hid/base_frame.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

using Matrix = std::array<std::array<long double, 3>, 3>;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

Matrix transposed(const Matrix& a) {
  Matrix t{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) t[j][i] = a[i][j];
  }
  return t;
}

Matrix of_axes(const AxisMapping& map) {
  Matrix m{};
  for (std::size_t i = 0; i < 3; ++i) m[i][map.raw_axis[i]] = map.sign[i];
  return m;
}

/// a x v as a matrix.
Matrix cross_of(const Array3& a) {
  return {{{0.0L, -a[2], a[1]}, {a[2], 0.0L, -a[0]}, {-a[1], a[0], 0.0L}}};
}

Matrix rotation_of(const Array4& q) {
  const long double w = q[0];
  const long double x = q[1];
  const long double y = q[2];
  const long double z = q[3];
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

long double difference(const Matrix& a, const Matrix& b) {
  long double most = 0.0L;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) most = std::max(most, std::abs(a[i][j] - b[i][j]));
  }
  return most;
}

Array3 times(const Matrix& m, const Array3& v) {
  Array3 out{};
  for (std::size_t i = 0; i < 3; ++i) {
    long double sum = 0.0L;
    for (std::size_t j = 0; j < 3; ++j) sum += m[i][j] * v[j];
    out[i] = static_cast<double>(sum);
  }
  return out;
}

double dot(const Array3& a, const Array3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

std::vector<AxisMapping> all_choices() {
  std::vector<AxisMapping> choices;
  const std::vector<std::array<std::uint8_t, 3>> orders{{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                                        {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  choices.reserve(48);
  for (const auto& order : orders) {
    for (unsigned signs = 0; signs < 8; ++signs) {
      AxisMapping map;
      map.raw_axis = order;
      for (std::size_t i = 0; i < 3; ++i) map.sign[i] = (signs >> i & 1U) != 0 ? -1.0 : 1.0;
      choices.push_back(map);
    }
  }
  return choices;
}

Array3 vector_of(SplitMix64& random) {
  return {random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)};
}

DeviceSample sample_of(SplitMix64& random) {
  DeviceSample sample;
  sample.p_DH = vector_of(random);
  sample.v_DH_D = vector_of(random);
  sample.w_DH_D = vector_of(random);
  const Array3 axis = random.direction();
  const double angle = random.uniform(-3.0, 3.0);
  const double s = std::sin(0.5 * angle);
  sample.q_DH = {std::cos(0.5 * angle), s * axis[0], s * axis[1], s * axis[2]};
  return sample;
}

/// The map back.
AxisMapping inverse(const AxisMapping& map) {
  AxisMapping back;
  for (std::size_t i = 0; i < 3; ++i) {
    back.raw_axis[map.raw_axis[i]] = static_cast<std::uint8_t>(i);
    back.sign[map.raw_axis[i]] = map.sign[i];
  }
  return back;
}

}  // namespace

TEST_CASE("poses and velocities turn and mirror as the matrix of the axes says") {
  SplitMix64 random(1);
  for (const AxisMapping& map : all_choices()) {
    CAPTURE(int{map.raw_axis[0]});
    CAPTURE(int{map.raw_axis[1]});
    const Matrix m = of_axes(map);
    const DeviceSample raw = sample_of(random);
    DeviceSample sample = raw;
    hid::into_base(map, sample);
    CHECK(sample.p_DH == times(m, raw.p_DH));
    CHECK(sample.v_DH_D == times(m, raw.v_DH_D));
    const auto conjugate = [&m](const Matrix& a) { return product(product(m, a), transposed(m)); };
    CHECK(difference(rotation_of(sample.q_DH), conjugate(rotation_of(raw.q_DH))) < 1e-15L);
    CHECK(difference(cross_of(sample.w_DH_D), conjugate(cross_of(raw.w_DH_D))) == 0.0L);
  }
}

TEST_CASE(
    "what the motors do by the hand is in both frames the same power, at every handle speed") {
  SplitMix64 random(2);
  for (AxisMapping map : all_choices()) {
    for (double& sign : map.force_sign) sign = random.chance(0.5) ? 1.0 : -1.0;
    const Matrix m = of_axes(map);
    DeviceCommand wanted;
    wanted.f_H_D = vector_of(random);
    wanted.t_H_D = vector_of(random);
    DeviceCommand told = wanted;
    hid::from_base(map, told);
    // A device whose motors are wired as force_sign says, along the axes of D.
    Array3 felt = times(m, told.f_H_D);
    for (std::size_t i = 0; i < 3; ++i) felt[i] *= map.force_sign[i];
    felt = times(transposed(m), felt);
    for (int k = 0; k < 5; ++k) {
      const DeviceSample raw = sample_of(random);
      DeviceSample sample = raw;
      hid::into_base(map, sample);
      // Of sums that cancel the rounding of their terms is left.
      CHECK(std::abs(dot(felt, raw.v_DH_D) - dot(wanted.f_H_D, sample.v_DH_D)) < 2e-14);
      CHECK(std::abs(dot(told.t_H_D, raw.w_DH_D) - dot(wanted.t_H_D, sample.w_DH_D)) < 2e-14);
    }
  }
}

namespace {

/// By rows, K way.
Array3 pulled(const std::array<double, 6>& K, const Array3& way) {
  return {K[0] * way[0] + K[3] * way[1] + K[4] * way[2],
          K[3] * way[0] + K[1] * way[1] + K[5] * way[2],
          K[4] * way[0] + K[5] * way[1] + K[2] * way[2]};
}

}  // namespace

TEST_CASE("the spring told pulls in the device's axes as the spring wanted does in D") {
  SplitMix64 random(5);
  for (AxisMapping map : all_choices()) {
    map.position_scale = {2.0, 2.0, 2.0};
    map.force_scale = {0.5, 0.5, 0.5};
    DeviceCommand wanted;
    for (double& entry : wanted.spring.K_D) entry = random.uniform(-100.0, 100.0);
    wanted.spring.Kr_D = vector_of(random);
    DeviceCommand told = wanted;
    hid::from_base(map, told);
    const DeviceSample raw = sample_of(random);
    DeviceSample sample = raw;
    hid::into_base(map, sample);
    // Ways turn like positions, forces like forces, and turns like angular velocities.
    DeviceCommand force;
    force.f_H_D = pulled(wanted.spring.K_D, sample.p_DH);
    for (std::size_t i = 0; i < 3; ++i) {
      force.t_H_D[i] = wanted.spring.Kr_D[i] * sample.w_DH_D[i];
    }
    hid::from_base(map, force);
    const Array3 pull = pulled(told.spring.K_D, raw.p_DH);
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(pull[i] == within(force.f_H_D[i], 1e-12));
      CHECK(told.spring.Kr_D[i] * raw.w_DH_D[i] == within(force.t_H_D[i], 1e-12));
    }
  }
}

TEST_CASE("no spring is told where axes differ in scale, or feel a force against its sign") {
  DeviceCommand wanted;
  wanted.spring.K_D = {100.0, 100.0, 100.0, 0.0, 0.0, 0.0};
  wanted.spring.Kr_D = {1.0, 1.0, 1.0};
  const auto told_by = [&](const AxisMapping& map) {
    DeviceCommand told = wanted;
    hid::from_base(map, told);
    return told.spring;
  };
  CHECK_FALSE(is_none(told_by({})));
  AxisMapping longer;
  longer.position_scale[1] = 2.0;
  CHECK(is_none(told_by(longer)));
  AxisMapping stronger;
  stronger.force_scale[2] = 2.0;
  CHECK(is_none(told_by(stronger)));
  for (std::size_t i = 0; i < 3; ++i) {
    AxisMapping against;
    against.force_sign[i] = -1.0;
    CHECK(is_none(told_by(against)));
  }
}

TEST_CASE("a choice of axes and the one back leave a sample and a command as they were") {
  SplitMix64 random(3);
  for (const AxisMapping& map : all_choices()) {
    const DeviceSample raw = sample_of(random);
    DeviceSample sample = raw;
    hid::into_base(map, sample);
    hid::into_base(inverse(map), sample);
    CHECK(sample.p_DH == raw.p_DH);
    CHECK(sample.q_DH == raw.q_DH);
    CHECK(sample.v_DH_D == raw.v_DH_D);
    CHECK(sample.w_DH_D == raw.w_DH_D);
    DeviceCommand command;
    command.f_H_D = vector_of(random);
    command.t_H_D = vector_of(random);
    DeviceCommand told = command;
    hid::from_base(map, told);
    hid::from_base(inverse(map), told);
    CHECK(told.f_H_D == command.f_H_D);
    CHECK(told.t_H_D == command.t_H_D);
  }
}

TEST_CASE("scales are of lengths and of forces, each along its axis of D, and of no angle") {
  AxisMapping map;
  map.raw_axis = {2, 0, 1};
  map.position_scale = {2.0, 3.0, 5.0};
  map.rotation_scale = {7.0, 7.0, 7.0};
  map.force_scale = {0.5, 0.25, 0.125};
  DeviceSample sample;
  sample.p_DH = sample.v_DH_D = sample.w_DH_D = {1.0, 10.0, 100.0};
  hid::into_base(map, sample);
  CHECK(sample.p_DH == Array3{200.0, 3.0, 50.0});
  CHECK(sample.v_DH_D == Array3{200.0, 3.0, 50.0});
  CHECK(sample.w_DH_D == Array3{100.0, 1.0, 10.0});
  DeviceCommand command;
  command.f_H_D = command.t_H_D = {1.0, 10.0, 100.0};
  hid::from_base(map, command);
  CHECK(command.f_H_D == Array3{40.0, 800.0, 2.0});
  CHECK(command.t_H_D == Array3{10.0, 100.0, 1.0});
}

TEST_CASE(
    "a map that leaves readings as they are leaves every bit, of zeros and of what is no number") {
  const auto bits = [](const auto& a) {
    std::vector<std::uint64_t> all;
    all.reserve(a.size());
    for (const double value : a) all.push_back(std::bit_cast<std::uint64_t>(value));
    return all;
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  DeviceSample raw;
  raw.p_DH = {-0.0, 5e-324, kNaN};
  raw.q_DH = {-0.0, 0.1, -0.2, 0.3};
  raw.v_DH_D = {kInfinity, -1.0 / 3.0, 0.0};
  raw.w_DH_D = {-0.0, -kInfinity, 1e308};
  DeviceSample sample = raw;
  hid::into_base({}, sample);
  CHECK(bits(sample.p_DH) == bits(raw.p_DH));
  CHECK(bits(sample.q_DH) == bits(raw.q_DH));
  CHECK(bits(sample.v_DH_D) == bits(raw.v_DH_D));
  CHECK(bits(sample.w_DH_D) == bits(raw.w_DH_D));
  DeviceCommand command;
  command.f_H_D = raw.p_DH;
  command.t_H_D = raw.w_DH_D;
  hid::from_base({}, command);
  CHECK(bits(command.f_H_D) == bits(raw.p_DH));
  CHECK(bits(command.t_H_D) == bits(raw.w_DH_D));
}

}  // namespace hapticd::test
