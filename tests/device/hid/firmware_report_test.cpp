// Reports, features and calibration of the reference firmware, by PROFILE.md, sections 3, 5, 6 and
// 8; and which affine commands it refuses.
#include <doctest/doctest.h>

#include "tests/device/hid/firmware_bench.h"

namespace hapticd::test {
namespace {

using hid::CalibrationOp;
using hid::CalibrationState;
using hid::kCommandEnable;

TEST_CASE("a report tells the newest measurement, in its own units") {
  Bench bench(hid::kHasVelocity | hid::kHasTemperature);
  bench.now_us = kState.t_us - 125;
  for (std::size_t i = 0; i < 3; ++i) {
    bench.sensors.pos_nm[i] = kState.pos_nm[i];
    bench.sensors.vel[i] = kState.vel_100ums[i];
    bench.sensors.avel[i] = kState.avel_mradps[i];
  }
  for (std::size_t i = 0; i < 4; ++i) bench.sensors.quat_q30[i] = kState.quat_q30[i];
  bench.sensors.grip = kState.grip_10um;
  bench.sensors.grip_vel = kState.grip_vel_mmps;
  bench.sensors.buttons = kState.buttons;
  bench.sensors.temp_c = kState.temp_deg_c;
  bench.sensors.load = kState.load;
  bench.servo();
  hid::StateReport expected = kState;
  expected.status = hid::kStatusCalibrated;
  expected.seq = 0;
  expected.cmd_seq = 0;
  expected.cmd_age = hid::kOldestCommand;
  CHECK(bench.state() == expected);
  // What is not measured is not made up.
  Bench poor;
  poor.sensors = bench.sensors;
  poor.servo();
  const hid::StateReport state = poor.state();
  CHECK(state.vel_100ums == std::array<std::int16_t, 3>{});
  CHECK(state.avel_mradps == std::array<std::int16_t, 3>{});
  CHECK(state.temp_deg_c == hid::kUnknownTemperature);
}

TEST_CASE("a report that was not fetched is replaced, and seq counts it all the same") {
  Bench bench;
  HapState report;
  CHECK_FALSE(hap_take_report(&bench.device, &report));
  for (int k = 0; k < 3; ++k) {
    bench.sensors.pos_nm[0] = k;
    bench.servo();
    hap_sample(&bench.device);
  }
  CHECK(hap_take_report(&bench.device, &report));
  // By value: fields of packed structs are not aligned.
  CHECK(std::uint16_t{report.seq} == 2);
  CHECK(std::int32_t{report.pos_nm[0]} == 2);
  CHECK_FALSE(hap_take_report(&bench.device, &report));
  CHECK(bench.state().seq == 3);
}

TEST_CASE("seq wraps") {
  Bench bench;
  bench.servo();
  for (std::uint32_t k = 0; k < 65'535; ++k) hap_sample(&bench.device);
  CHECK(bench.state().seq == 65'535);
  CHECK(bench.state().seq == 0);
}

TEST_CASE("the clock may wrap while forces flow: the watchdog counts on") {
  Bench bench;
  bench.now_us = 0xFFFFFFFF - 10'000;
  REQUIRE(bench.enable());
  bench.send_flags(kCommandEnable);
  const std::uint32_t sent_us = bench.now_us;
  CHECK(bench.servo(19'999).motors_on);
  CHECK(bench.now_us < sent_us);
  CHECK(bench.state().cmd_age == 1999);
  CHECK_FALSE(bench.servo(1).motors_on);
}

TEST_CASE("a report echoes the last command accepted, and its age") {
  Bench bench;
  bench.servo();
  bench.send_flags(0);
  bench.servo(105);
  hid::StateReport state = bench.state();
  CHECK(state.cmd_seq == 1);
  CHECK(state.cmd_age == 10);
  bench.now_us += 50;
  bench.send_flags(0);  // after the sample
  state = bench.state();
  CHECK(state.cmd_seq == 2);
  CHECK(state.cmd_age == 0);
  bench.servo(655'340);
  CHECK(bench.state().cmd_age == 65'534);
  bench.servo(10);
  CHECK(bench.state().cmd_age == 65'535);
  // Old stays old where the clock wraps onto the command's instant.
  bench.send_flags(0);
  const std::uint32_t sent_us = bench.now_us;
  bench.servo(0x80000000);
  bench.servo(sent_us + 100 - bench.now_us);
  CHECK(bench.state().cmd_age == 65'535);
}

TEST_CASE("features are those of the settings; there is no other one") {
  Bench bench(kCapabilities.caps);
  hid::Capabilities capabilities;
  REQUIRE(hid::decode_capabilities(bench.feature(kHapCapabilitiesId), capabilities) ==
          hid::Decoded::kOk);
  CHECK(capabilities == kCapabilities);
  bench.send(kConfig);
  CHECK(bench.feature(kHapConfigId) ==
        std::vector<std::uint8_t>(kConfigBytes.begin(), kConfigBytes.end()));
  for (unsigned id = 0; id < 256; ++id) {
    const auto bytes = bench.feature(static_cast<std::uint8_t>(id));
    CHECK(bytes.empty() == (id < 0x10 || id > 0x12));
  }
  std::uint8_t few[63];
  CHECK(hap_get_feature(&bench.device, kHapCapabilitiesId, few, sizeof few) == 0);
}

TEST_CASE("a device that needs calibration does not enable without it, nor while it runs") {
  Bench bench(hid::kNeedsCalibration);
  CHECK_FALSE(bench.enable());
  CHECK_FALSE(bench.shows(hid::kStatusCalibrated));
  CHECK(bench.send(CalibrationOp::kStart));
  std::uint16_t axes = 0;
  CHECK(hap_take_calibration(&bench.device, &axes) == kHapStart);
  CHECK(axes == 0x7F);
  CHECK(hap_take_calibration(&bench.device, &axes) == 0);
  hap_calibration_progress(&bench.device, 40);
  CHECK(bench.calibration() ==
        hid::Calibration{CalibrationOp::kStart, CalibrationState::kRunning, 40, 0});
  CHECK_FALSE(bench.enable());
  hap_calibration_end(&bench.device, true);
  CHECK(bench.feature(kHapCalibrationId) ==
        std::vector<std::uint8_t>(kCalibrationBytes.begin(), kCalibrationBytes.end()));
  CHECK(bench.shows(hid::kStatusCalibrated));
  CHECK(bench.enable());
}

TEST_CASE("a calibration that begins ends the force, and so does a new zero") {
  for (const CalibrationOp op : {CalibrationOp::kStart, CalibrationOp::kZeroHere}) {
    Bench bench;
    REQUIRE(bench.enable());
    CHECK(bench.send(op));
    CHECK(is_zero(bench.push(1'000'000)));
    hap_calibration_end(&bench.device, true);
    CHECK(is_zero(bench.push(0)));
    CHECK(bench.enable());
  }
}

TEST_CASE("an aborted calibration leaves the old one, a failed one does not") {
  Bench bench(hid::kNeedsCalibration);
  CHECK(bench.send(CalibrationOp::kAbort));  // nothing runs: no effect
  CHECK(bench.calibration().state == CalibrationState::kNone);
  CHECK(bench.send(CalibrationOp::kZeroHere, 0x1F));
  CHECK(bench.calibration().state == CalibrationState::kNone);
  CHECK(bench.calibration().axis_mask == 0x1F);
  CHECK(bench.send(CalibrationOp::kZeroHere, 0x20));
  CHECK(bench.calibration().state == CalibrationState::kOk);
  bench.send(CalibrationOp::kStart, 0x01);
  CHECK_FALSE(bench.shows(hid::kStatusCalibrated));
  bench.send(CalibrationOp::kAbort);
  CHECK(bench.calibration().state == CalibrationState::kOk);
  CHECK(bench.shows(hid::kStatusCalibrated));
  bench.send(CalibrationOp::kStart, 0x01);
  hap_calibration_end(&bench.device, false);
  CHECK(bench.calibration() ==
        hid::Calibration{CalibrationOp::kStart, CalibrationState::kFailed, 0, 0x3E});
  CHECK_FALSE(bench.shows(hid::kStatusCalibrated));
  // Who is not asked has nothing to say.
  hap_calibration_end(&bench.device, true);
  hap_calibration_progress(&bench.device, 50);
  CHECK(bench.calibration().state == CalibrationState::kFailed);
  CHECK(bench.calibration().progress == 0);
}

TEST_CASE("an op out of place or unknown is refused and marked") {
  Bench bench;
  CHECK_FALSE(bench.send(CalibrationOp::kStore));
  CHECK(bench.state().fault == hid::kFaultBadCommand);
  CHECK(bench.send(CalibrationOp::kStart));
  CHECK_FALSE(bench.send(CalibrationOp::kZeroHere));
  hap_calibration_end(&bench.device, true);
  CHECK(bench.send(CalibrationOp::kStore));
  std::uint16_t axes = 0;
  CHECK(hap_take_calibration(&bench.device, &axes) == kHapStore);
  for (unsigned op = 0; op < 256; ++op) {
    if (op >= 1 && op <= 4) continue;
    CAPTURE(op);
    CHECK_FALSE(bench.send(static_cast<CalibrationOp>(op)));
  }
  CHECK(bench.calibration().op == CalibrationOp::kStore);
}

TEST_CASE("an affine command about a pose long gone, or one never sent, is refused") {
  Bench bench(hid::kCanAffine);
  hid::AffineReport affine{.base = {.ref_seq = 0}};
  CHECK_FALSE(bench.send(affine));
  for (std::uint16_t newest = 0; newest < 300; ++newest) {
    bench.servo();
    CHECK(bench.state().seq == newest);
    // At least the last 16 reports.
    for (std::uint16_t back = 0; back < 16 && back <= newest; ++back) {
      affine.base.ref_seq = static_cast<std::uint16_t>(newest - back);
      CHECK(bench.send(affine));
    }
    affine.base.ref_seq = static_cast<std::uint16_t>(newest + 1);
    CHECK_FALSE(bench.send(affine));
    affine.base.ref_seq = static_cast<std::uint16_t>(newest - kHapHistory);
    CHECK_FALSE(bench.send(affine));
  }
  CHECK(bench.state().cmd_seq != bench.seq);
}

TEST_CASE("an affine command with a stiffness below zero, or too much of it, is refused") {
  Bench bench(hid::kCanAffine);  // k_max is 3000 N/m
  bench.servo();
  const std::uint16_t ref_seq = bench.state().seq;
  const auto takes = [&](const std::array<std::int16_t, 6>& k_npm) {
    return bench.send(hid::AffineReport{.base = {.ref_seq = ref_seq}, .k_npm = k_npm});
  };
  CHECK(takes({3000, 3000, 3000, 0, 0, 0}));
  CHECK_FALSE(takes({3001, 0, 0, 0, 0, 0}));
  CHECK_FALSE(takes({0, 0, 3001, 0, 0, 0}));
  CHECK_FALSE(takes({-1, 0, 0, 0, 0, 0}));
  CHECK_FALSE(takes({0, -1, 0, 0, 0, 0}));
  CHECK(takes({1000, 1000, 1000, -1000, 1000, -1000}));
  CHECK_FALSE(takes({1000, 1000, 1000, -1000, 1001, 0}));
  CHECK_FALSE(takes({1000, 1000, 1000, 0, 1001, -1000}));
  Bench plain;
  plain.servo();
  plain.state();
  CHECK_FALSE(plain.send(hid::AffineReport{}));
}

}  // namespace
}  // namespace hapticd::test
