// Raw units of HID profile v1 against SI, by the worked reports of PROFILE.md and by the ends of
// every range.
#include "device/hid/profile_units.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "device/hid/counter_unwrap.h"
#include "device/hid/profile_codec.h"
#include "tests/device/hid/worked_reports.h"
#include "tests/support/no_heap.h"

namespace hapticd::test {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Rounding of a product or two in double.
constexpr double kRounding = 1e-15;

bool near(double value, double truth) {
  return std::abs(value - truth) <= kRounding * std::abs(truth);
}

TEST_CASE("a state in SI: metres, unit orientation, metres and radians per second") {
  DeviceSample sample;
  sample.t_ns = 5;
  sample.counter = 6;
  hid::to_sample(kState, kCapabilities, sample);
  CHECK(near(sample.p_DH[0], 0.01));
  CHECK(near(sample.p_DH[1], -0.005));
  CHECK(near(sample.p_DH[2], 1e-9));
  // A quarter turn about x; Q30 knows it to 1e-9.
  CHECK(std::abs(sample.q_DH[0] - std::sqrt(0.5)) < 1e-9);
  CHECK(std::abs(sample.q_DH[1] - std::sqrt(0.5)) < 1e-9);
  double square = 0.0;
  for (const double q : sample.q_DH) square += q * q;
  CHECK(std::abs(square - 1.0) < 1e-15);
  CHECK(sample.has_velocity);
  CHECK(near(sample.v_DH_D[0], 0.1));
  CHECK(near(sample.v_DH_D[1], -1e-4));
  CHECK(near(sample.w_DH_D[1], 0.5));
  CHECK(near(sample.w_DH_D[2], -0.5));
  CHECK(sample.grip_m == doctest::Approx(0.01234));
  CHECK(sample.temperature_deg_c == 45.0F);
  CHECK(sample.buttons == 3);
  // What only the driver knows is left alone.
  CHECK(sample.t_ns == 5);
  CHECK(sample.counter == 6);
}

TEST_CASE("what the device does not measure is said to be missing") {
  hid::Capabilities capabilities = kCapabilities;
  capabilities.caps = 0;
  capabilities.dof = 0x0FFF;
  DeviceSample sample;
  hid::to_sample(kState, capabilities, sample);
  CHECK_FALSE(sample.has_velocity);
  CHECK(sample.v_DH_D == Array3{});
  CHECK(std::isnan(sample.grip_m));
  CHECK(std::isnan(sample.temperature_deg_c));
  hid::StateReport state = kState;
  state.temp_deg_c = 255;
  hid::to_sample(state, kCapabilities, sample);
  CHECK(std::isnan(sample.temperature_deg_c));
}

TEST_CASE("each status bit is one flag of the sample") {
  struct Pair {
    int status;
    unsigned flag;
  };
  for (const Pair pair : {Pair{0x01, kDeviceEnabled}, Pair{0x02, kDeviceCalibrated}, Pair{0x04, 0U},
                          Pair{0x08, kDeviceDeadManHeld}, Pair{0x10, kDeviceWatchdogFired},
                          Pair{0x20, kDeviceSaturated}, Pair{0x40, kDeviceEmergencyStop},
                          Pair{0x80, kDeviceReportsFault}}) {
    CAPTURE(pair.status);
    hid::StateReport state = kState;
    state.status = static_cast<std::uint8_t>(pair.status);
    DeviceSample sample;
    hid::to_sample(state, kCapabilities, sample);
    CHECK(sample.flags == (kDeviceAttached | pair.flag));
  }
}

DeviceCommand command_of(const Array3& f_H_D, const Array3& t_H_D) {
  DeviceCommand command;
  command.f_H_D = f_H_D;
  command.t_H_D = t_H_D;
  command.enable = true;
  return command;
}

TEST_CASE("a wrench in newtons becomes whole micronewtons, the nearest") {
  hid::CommandReport report = kCommand;
  report.flags = hid::kCommandGrip;
  CHECK(hid::to_command(command_of({1.5, -0.25, 4.9e-7}, {0.0, 0.01, -5.1e-7}), report));
  CHECK(report.force_un == std::array<std::int32_t, 3>{1'500'000, -250'000, 0});
  CHECK(report.torque_unm == std::array<std::int32_t, 3>{0, 10'000, -1});
  CHECK(report.flags == (hid::kCommandGrip | hid::kCommandEnable));
  CHECK(report.seq == kCommand.seq);
  CHECK(report.ref_seq == kCommand.ref_seq);
  CHECK(report.grip_mn == kCommand.grip_mn);
}

TEST_CASE("a wrench beyond the range stops at its end") {
  hid::CommandReport report;
  CHECK(hid::to_command(command_of({1e300, -1e300, 2147.483648}, {2148.0, -2148.0, 0.0}), report));
  CHECK(report.force_un == std::array<std::int32_t, 3>{INT32_MAX, INT32_MIN, INT32_MAX});
  CHECK(report.torque_unm == std::array<std::int32_t, 3>{INT32_MAX, INT32_MIN, 0});
}

TEST_CASE("a wrench that is not finite is refused and no force sent instead") {
  for (const double bad : {kNaN, kInf, -kInf}) {
    for (std::size_t axis = 0; axis < 6; ++axis) {
      DeviceCommand command = command_of({1.0, 1.0, 1.0}, {1.0, 1.0, 1.0});
      (axis < 3 ? command.f_H_D[axis] : command.t_H_D[axis - 3]) = bad;
      hid::CommandReport report = kCommand;
      CHECK_FALSE(hid::to_command(command, report));
      CHECK(report.force_un == std::array<std::int32_t, 3>{});
      CHECK(report.torque_unm == std::array<std::int32_t, 3>{});
      hid::AffineReport affine = kAffine;
      CHECK_FALSE(hid::to_affine(command, {{1, 1, 1, 0, 0, 0}, {1, 1, 1}, {}, {}}, affine));
      CHECK(affine.k_npm == std::array<std::int16_t, 6>{});
      CHECK(affine.b_mnspm == std::array<std::uint16_t, 3>{});
      CHECK(affine.base.force_un == std::array<std::int32_t, 3>{});
    }
  }
}

TEST_CASE("a command that is not to enable carries no wrench and no gains") {
  DeviceCommand command = command_of({1.0, 0.0, 0.0}, {1.0, 0.0, 0.0});
  command.enable = false;
  hid::AffineReport report = kAffine;
  CHECK(
      hid::to_affine(command, {{500, 500, 500, 0, 0, 0}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, report));
  CHECK(report == hid::AffineReport{.base = {.seq = 257, .ref_seq = 0x1234}});
}

TEST_CASE("gains in SI become those of the affine report") {
  hid::AffineReport report;
  report.base.seq = 257;
  report.base.ref_seq = 0x1234;
  CHECK(hid::to_affine(command_of({}, {}),
                       {.K = {500.0, 500.0, 800.0, 0.0, -100.0, 0.0},
                        .B = {2.0, 2.0, 2.0},
                        .Kr = {0.05, 0.05, 0.05},
                        .Br = {0.001, 0.001, 0.001}},
                       report));
  CHECK(report == kAffine);
}

TEST_CASE("a stiffness beyond the range is scaled as a whole; dampings stop at their ends") {
  hid::AffineReport report;
  CHECK(hid::to_affine(command_of({}, {}),
                       {.K = {65534.0, 32767.0, 0.0, -6553.4, 0.0, 0.0},
                        .B = {100.0, 0.0, 65.535},
                        .Kr = {100.0, 0.0, 0.0},
                        .Br = {1e300, 0.0, 0.0}},
                       report));
  CHECK(report.k_npm == std::array<std::int16_t, 6>{32767, 16384, 0, -3277, 0, 0});
  CHECK(report.b_mnspm == std::array<std::uint16_t, 3>{65535, 0, 65535});
  CHECK(report.kr_mnmprad[0] == 65535);
  CHECK(report.br_10unmsprad[0] == 65535);
}

TEST_CASE("gains that push away, or are no numbers, are refused") {
  const hid::AffineGains good{{1, 1, 1, -1, 0, 0}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  hid::AffineReport report;
  CHECK(hid::to_affine(command_of({}, {}), good, report));
  for (const double bad : {-1e-9, kNaN, kInf}) {
    for (std::size_t i = 0; i < 12; ++i) {
      hid::AffineGains gains = good;
      Array3* diagonal = i < 6 ? &gains.B : i < 9 ? &gains.Kr : &gains.Br;
      (i < 3 ? gains.K[i] : (*diagonal)[i % 3]) = bad;
      CHECK_FALSE(hid::to_affine(command_of({1, 1, 1}, {}), gains, report));
      CHECK(report.k_npm == std::array<std::int16_t, 6>{});
      CHECK(report.base.force_un == std::array<std::int32_t, 3>{});
    }
  }
}

TEST_CASE("capabilities become limits of the device profile") {
  DeviceProfile profile;
  profile.damping = 3.0;
  hid::apply_capabilities(kCapabilities, profile);
  CHECK(profile.driver == DeviceDriver::kHid);
  CHECK(profile.sensed_axes == 6);
  CHECK(profile.actuated_axes == 6);
  CHECK(near(profile.peak_force, 9.0));
  CHECK(near(profile.continuous_force, 3.0));
  CHECK(near(profile.peak_torque, 0.3));
  CHECK(near(profile.continuous_torque, 0.1));
  CHECK(profile.stiffness_max == 3000.0);
  CHECK(near(profile.workspace_lower[0], -0.1));
  CHECK(near(profile.workspace_upper[2], 0.06));
  CHECK(near(profile.rotation_range[2], 3.142));
  CHECK(near(profile.mass[1], 0.12));
  CHECK(near(profile.position_resolution[0], 5e-6));
  CHECK(near(profile.rotation_resolution[0], 1e-4));
  CHECK(profile.report_rate == 1000.0);
  CHECK(near(profile.watchdog, 0.02));
  CHECK(profile.damping == 3.0);
}

TEST_CASE("what capabilities leave open stays as the profile has it") {
  hid::Capabilities open = kCapabilities;
  open.k_max_npm = open.mass_g = open.f_cont_cn = open.tau_cont_mnm = 0;
  open.ws_min_mm = open.ws_max_mm = {};
  open.rot_range_mrad = {};
  open.dof = 0x01C7;  // position sensed, force
  DeviceProfile profile;
  profile.stiffness_max = 1234.0;
  hid::apply_capabilities(open, profile);
  CHECK(profile.sensed_axes == 3);
  CHECK(profile.actuated_axes == 3);
  CHECK(profile.stiffness_max == 1234.0);
  CHECK(profile.workspace_lower[0] == -kUnlimited);
  CHECK(profile.rotation_range[0] == kUnlimited);
  CHECK(profile.mass[0] == DeviceProfile{}.mass[0]);
  // No continuous force said: the peak is all that is known.
  CHECK(near(profile.continuous_force, 9.0));
  CHECK(near(profile.continuous_torque, 0.3));
}

TEST_CASE("what runs every tick leaves the heap alone") {
  DeviceSample sample;
  hid::StateReport state;
  hid::AffineReport affine;
  hid::CounterUnwrap<std::uint16_t> counter;
  NoHeapScope scope;
  bool all = hid::decode_state(kStateBytes, state) == hid::Decoded::kOk;
  hid::to_sample(state, kCapabilities, sample);
  all = all && hid::unwrap(state.seq, counter) != 0;
  all = all && hid::to_affine(command_of({1, 2, 3}, {}), {}, affine);
  all = all && hid::encode(affine)[0] == hid::kAffineId;
  all = all && hid::encode(affine.base)[0] == hid::kCommandId;
  const std::int64_t touched = scope.count();
  CHECK(all);
  CHECK(touched == 0);
}

TEST_CASE("limits of a session become a config within the capabilities, rounded down") {
  CHECK(hid::to_config({0.01, 4.0, 0.15, 1.5, false}, kCapabilities) == kConfig);
  CHECK(hid::to_config({0.0109, 4.009, 0.1509, 1.5009, true}, kCapabilities) == kConfig);
  const hid::Config most = hid::to_config({kInf, kInf, kInf, kInf, false}, kCapabilities);
  CHECK(most.wd_ms == 100);
  CHECK(most.f_cap_cn == 900);
  CHECK(most.tau_cap_mnm == 300);
  CHECK(most.v_cap_mmps == hid::kNoSpeedCap);
  for (const double bad : {kNaN, -1.0}) {
    const hid::Config least = hid::to_config({bad, bad, bad, bad, false}, kCapabilities);
    CHECK(least.wd_ms == 2);
    CHECK(least.f_cap_cn == 0);
    CHECK(least.tau_cap_mnm == 0);
    CHECK(least.v_cap_mmps == 0);
  }
  hid::Capabilities heavy = kCapabilities;
  heavy.caps |= hid::kCanGravity;
  CHECK(hid::to_config({0.01, 4.0, 0.15, 1.5, true}, heavy).grav_comp == 1);
}

}  // namespace
}  // namespace hapticd::test
