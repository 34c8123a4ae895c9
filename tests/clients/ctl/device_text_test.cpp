// Lines about devices. Truth: the numbers put in.
#include "clients/ctl/device_text.h"

#include <doctest/doctest.h>

#include <cmath>

namespace hapticd::test {
namespace {

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

v1::State ready() {
  v1::State state;
  state.set_tick(7);
  state.set_loop_state(v1::LOOP_STATE_READY);
  v1::DeviceState& device = *state.add_devices();
  device.set_tool_id(2);
  for (const double p : {0.01, -0.02, 0.03}) device.add_p_dh_m(p);
  // 90 degrees about y.
  for (const double q : {std::sqrt(0.5), 0.0, std::sqrt(0.5), 0.0}) {
    device.add_q_dh(static_cast<float>(q));
  }
  device.set_buttons(0b101);
  device.add_flags(v1::DEVICE_FLAG_ATTACHED);
  device.add_flags(v1::DEVICE_FLAG_CALIBRATED);
  return state;
}

v1::State with(v1::DeviceFlag flag) {
  v1::State state = ready();
  state.mutable_devices(0)->add_flags(flag);
  return state;
}

}  // namespace

TEST_CASE("a device is described with where each number comes from, guesses marked") {
  v1::DeviceInfo info;
  info.set_tool_id(3);
  info.set_driver(v1::DRIVER_PID);
  info.set_serial("S9");
  info.set_force_limit_n(0.3);
  info.set_measured_delay_s(0.0025);
  info.set_calibration(v1::CALIBRATION_STATE_NEEDED);
  info.add_confirmed(v1::AXIS_NEGATIVE_X);
  v1::Quantity& peak = *info.mutable_profile()->mutable_peak_force_n();
  peak.add_value(1.0);
  peak.set_source("a choice");
  v1::Quantity& scale = *info.mutable_profile()->mutable_axis_map()->mutable_force_scale();
  scale.add_value(0.0031);
  scale.set_source("guess: ffb_defs.h");
  scale.set_guess(true);
  const std::string text = joined(ctl::info_lines(info));
  for (const char* part : {"tool 3: pid", "serial        S9", "0.3 N", "2.500 ms measured",
                           "device calibrate", "negative x", "peak_force_n", "1   [a choice]",
                           "0.0031   [GUESS: ffb_defs.h]", "watchdog      NONE"}) {
    CHECK_MESSAGE(contains(text, part), std::string(part), " is not in\n", text);
  }
  CHECK_FALSE(contains(text, "affine"));
  info.mutable_profile()->set_affine(true);
  CHECK(contains(joined(ctl::info_lines(info)), "affine        it renders the stiffness"));
}

TEST_CASE("an unchecked device is told with its limit and the command that checks it") {
  v1::DeviceInfo info;
  info.set_tool_id(1);
  info.set_force_limit_n(0.3);
  CHECK(contains(ctl::unchecked_text(info), "0.3 N"));
  CHECK(contains(ctl::unchecked_text(info), "hapticctl device check --tool 1"));
  info.set_checked(true);
  CHECK(ctl::unchecked_text(info).empty());
}

TEST_CASE("a device whose limit leaves no force says so, one without motors does not") {
  v1::DeviceInfo info;
  info.set_tool_id(3);
  info.set_force_limit_n(0.3);
  CHECK(ctl::no_force_text(info).empty());
  info.set_force_limit_n(0.0);
  CHECK(contains(ctl::no_force_text(info), "tool 3: no force"));
  info.mutable_profile()->mutable_actuated_axes()->add_value(2.0);
  CHECK(contains(ctl::no_force_text(info), "tool 3: no force"));
  info.mutable_profile()->mutable_actuated_axes()->set_value(0, 0.0);
  CHECK(ctl::no_force_text(info).empty());
}

TEST_CASE("readings are in millimetres and degrees, with buttons by number") {
  const std::string text = joined(ctl::reading_lines(ready(), std::nullopt));
  CHECK(contains(text, "10.00   -20.00    30.00 mm"));
  CHECK(contains(text, "0.00   90.00    0.00 deg"));
  CHECK(contains(text, "buttons 0 2"));
  CHECK_FALSE(contains(joined(ctl::reading_lines(ready(), 0)), "mm"));
}

TEST_CASE("an emergency stop and an open dead-man switch cannot be overlooked") {
  const auto shown = [](const v1::State& state) {
    return joined(ctl::reading_lines(state, std::nullopt));
  };
  CHECK(contains(shown(ready()), "no e-stop"));
  CHECK(contains(shown(with(v1::DEVICE_FLAG_EMERGENCY_STOP)), "EMERGENCY STOP"));
  CHECK(contains(shown(with(v1::DEVICE_FLAG_DEAD_MAN_HELD)), "dead-man held"));
  v1::State open = ready();
  open.set_cause(v1::CAUSE_DEAD_MAN);
  CHECK(contains(shown(open), "DEAD-MAN OPEN"));
}

TEST_CASE("a device that is not ready is refused with what to do, one that is is not") {
  CHECK(ctl::unready_text(ready(), 2).empty());
  CHECK(ctl::unready_text(with(v1::DEVICE_FLAG_DEAD_MAN_HELD), 2).empty());
  CHECK(contains(ctl::unready_text(ready(), 0), "no tool 0"));
  CHECK(contains(ctl::unready_text(with(v1::DEVICE_FLAG_EMERGENCY_STOP), 2), "Release it"));
  CHECK(contains(ctl::unready_text(with(v1::DEVICE_FLAG_FAULT), 2), "manual"));
  v1::State state = ready();
  state.set_cause(v1::CAUSE_DEAD_MAN);
  CHECK(contains(ctl::unready_text(state, 2), "Hold it"));
  state = ready();
  state.set_loop_state(v1::LOOP_STATE_FAULT);
  state.set_cause(v1::CAUSE_OVERRUN);
  CHECK(contains(ctl::unready_text(state, 2), "overrun"));
  state = ready();
  state.mutable_devices(0)->mutable_flags()->RemoveLast();
  CHECK(contains(ctl::unready_text(state, 2), "device calibrate"));
  state.mutable_devices(0)->clear_flags();
  CHECK(contains(ctl::unready_text(state, 2), "Plug it in"));
}

TEST_CASE("a State of one tool has no other") {
  v1::State state = ready();
  state.add_devices()->set_tool_id(5);
  state.add_tools()->set_tool_id(5);
  state.add_tools()->set_tool_id(2);
  const v1::State one = ctl::only_tool(state, 5);
  CHECK(one.devices_size() == 1);
  CHECK(one.devices(0).tool_id() == 5);
  CHECK(one.tools_size() == 1);
  CHECK(one.tick() == 7);
}

}  // namespace hapticd::test
