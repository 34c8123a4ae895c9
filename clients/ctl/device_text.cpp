// See device_text.h.
#include "clients/ctl/device_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "clients/ctl/text.h"

namespace hapticd::ctl {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  std::array<char, 400> buffer{};
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(buffer.data(), buffer.size(), pattern, arguments);
  va_end(arguments);
  return buffer.data();
}

/// Element i of a list that may be short.
template <typename List>
double at(const List& list, int i) {
  return i < list.size() ? static_cast<double>(list.Get(i)) : 0.0;
}

bool has(const v1::DeviceState& device, v1::DeviceFlag flag) {
  return std::find(device.flags().begin(), device.flags().end(), flag) != device.flags().end();
}

std::string cause_of(const v1::State& state) {
  return plain_name(v1::Cause_Name(state.cause()), "CAUSE_");
}

/// Where a number comes from; a guess says so in capitals, once.
std::string source_of(const v1::Quantity& number) {
  constexpr std::string_view kGuess = "guess: ";
  if (!number.guess()) return number.source();
  const bool said = number.source().starts_with(kGuess);
  return "GUESS: " + number.source().substr(said ? kGuess.size() : 0);
}

/// Every Quantity in a profile, with the name of its field, which ends in its unit.
void add_numbers(const google::protobuf::Message& message, std::vector<std::string>& lines) {
  const google::protobuf::Descriptor& fields = *message.GetDescriptor();
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < fields.field_count(); ++i) {
    const google::protobuf::FieldDescriptor* field = fields.field(i);
    if (field->message_type() != v1::Quantity::descriptor()) continue;
    if (!reflection.HasField(message, field)) continue;
    const auto& number = dynamic_cast<const v1::Quantity&>(reflection.GetMessage(message, field));
    std::string values;
    for (const double value : number.value()) values += format(" %g", value);
    lines.push_back(format("  %-34s%s", field->name().c_str(), values.c_str()) + "   [" +
                    source_of(number) + "]");
  }
}

std::string calibration_of(const v1::DeviceInfo& info) {
  switch (info.calibration()) {
    case v1::CALIBRATION_STATE_NEEDED:
      return "needed: hapticctl device calibrate";
    case v1::CALIBRATION_STATE_RUNNING:
      return format("running, %.0f %%", 100.0 * info.calibration_progress());
    case v1::CALIBRATION_STATE_DONE:
      return "done";
    case v1::CALIBRATION_STATE_FAILED:
      return "failed: hapticctl device calibrate";
    default:
      return "it has none, or does not say";
  }
}

std::string checked_of(const v1::DeviceInfo& info) {
  if (info.checked()) return "yes";
  std::string confirmed;
  for (const int axis : info.confirmed()) {
    confirmed += (confirmed.empty() ? "" : ", ") +
                 plain_name(v1::Axis_Name(static_cast<v1::Axis>(axis)), "AXIS_");
  }
  return "no: hapticctl device check" +
         (confirmed.empty() ? std::string() : " (confirmed so far: " + confirmed + ")");
}

std::string axes_of_map(const v1::AxisMap& map) {
  std::string axes;
  for (const int axis : map.axes()) {
    axes += (axes.empty() ? "" : ", ") +
            plain_name(v1::Axis_Name(static_cast<v1::Axis>(axis)), "AXIS_");
  }
  return axes.empty() ? "positive x, positive y, positive z" : axes;
}

/// Rotation vector of a unit quaternion w x y z, degrees.
std::array<double, 3> degrees(const v1::DeviceState& device) {
  const double w = at(device.q_dh(), 0);
  std::array<double, 3> v{at(device.q_dh(), 1), at(device.q_dh(), 2), at(device.q_dh(), 3)};
  const double sine = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const double angle = 2.0 * std::atan2(w < 0.0 ? -sine : sine, std::abs(w));
  const double scale = sine > 1e-9 ? angle / sine * kDegrees : 0.0;
  for (double& each : v) each *= scale;
  return v;
}

/// What a person must see at once comes in capitals.
std::string flags_of(const v1::DeviceState& device, const v1::State& state) {
  const bool held = has(device, v1::DEVICE_FLAG_DEAD_MAN_HELD);
  std::string text = has(device, v1::DEVICE_FLAG_ATTACHED) ? "attached" : "DETACHED";
  text += has(device, v1::DEVICE_FLAG_CALIBRATED) ? "  calibrated" : "  NOT CALIBRATED";
  text += has(device, v1::DEVICE_FLAG_ENABLED) ? "  motors on" : "  motors off";
  if (held) {
    text += "  dead-man held";
  } else {
    text +=
        state.cause() == v1::CAUSE_DEAD_MAN ? "  DEAD-MAN OPEN" : "  dead-man not held, or none";
  }
  text += has(device, v1::DEVICE_FLAG_EMERGENCY_STOP) ? "  EMERGENCY STOP" : "  no e-stop";
  if (has(device, v1::DEVICE_FLAG_WATCHDOG)) text += "  WATCHDOG";
  if (has(device, v1::DEVICE_FLAG_FAULT)) text += "  FAULT";
  if (has(device, v1::DEVICE_FLAG_SATURATED)) text += "  saturated";
  return text;
}

const v1::ToolState* tool_of(const v1::State& state, std::uint32_t tool_id) {
  for (const v1::ToolState& tool : state.tools()) {
    if (tool.tool_id() == tool_id) return &tool;
  }
  return nullptr;
}

void add_readings(const v1::DeviceState& device, const v1::State& state,
                  std::vector<std::string>& lines) {
  const std::array<double, 3> turn = degrees(device);
  lines.push_back(format("tool %u  p %8.2f %8.2f %8.2f mm   turned %7.2f %7.2f %7.2f deg",
                         device.tool_id(), 1e3 * at(device.p_dh_m(), 0),
                         1e3 * at(device.p_dh_m(), 1), 1e3 * at(device.p_dh_m(), 2), turn[0],
                         turn[1], turn[2]));
  lines.push_back("        " + flags_of(device, state));
  std::string rest = "        buttons";
  for (unsigned i = 0; i < 16; ++i) {
    if ((device.buttons() >> i & 1U) != 0) rest += format(" %u", i);
  }
  if (device.buttons() == 0) rest += " none";
  if (device.has_grip_m()) rest += format("   grip %.2f mm", 1e3 * double{device.grip_m()});
  if (device.has_temperature_deg_c()) {
    rest += format("   %.0f degC", double{device.temperature_deg_c()});
  }
  lines.push_back(rest);
  if (const v1::ToolState* tool = tool_of(state, device.tool_id())) {
    lines.push_back(format("        force %6.3f %6.3f %6.3f N   torque %7.4f %7.4f %7.4f N m",
                           at(tool->wrench_h_w(), 0), at(tool->wrench_h_w(), 1),
                           at(tool->wrench_h_w(), 2), at(tool->wrench_h_w(), 3),
                           at(tool->wrench_h_w(), 4), at(tool->wrench_h_w(), 5)));
  }
}

}  // namespace

std::vector<std::string> info_lines(const v1::DeviceInfo& info) {
  const v1::DeviceProfile& profile = info.profile();
  std::vector<std::string> lines{
      format("tool %u: %s", info.tool_id(),
             plain_name(v1::Driver_Name(info.driver()), "DRIVER_").c_str()) +
      (profile.description().empty() ? "" : ", " + profile.description())};
  lines.push_back("  serial        " + (info.serial().empty() ? "none" : info.serial()));
  lines.push_back("  port          " + info.port());
  lines.push_back("  checked       " + checked_of(info));
  lines.push_back(format("  force limit   %g N", info.force_limit_n()));
  lines.push_back("  calibration   " + calibration_of(info));
  lines.push_back("  delay         " +
                  (info.has_measured_delay_s()
                       ? format("%.3f ms measured", 1e3 * info.measured_delay_s())
                       : "not measured, the declared one counts"));
  lines.push_back(format("  stiffness     %.0f N/m at most", info.stiffness_bound_n_per_m()));
  for (const v1::MeasuredDamping& damping : info.damping()) {
    lines.push_back(format("  damping       %.2g to %.2g N s/m measured along ",
                           damping.lower_n_s_per_m(), damping.upper_n_s_per_m()) +
                    plain_name(v1::Axis_Name(damping.axis()), "AXIS_"));
  }
  if (info.driver() == v1::DRIVER_PID) {
    lines.emplace_back("  watchdog      NONE: it keeps pushing if hapticd dies, so 1 N at most");
  }
  if (profile.affine()) {
    lines.emplace_back("  affine        it renders the stiffness of contacts by itself");
  }
  lines.push_back("  profile       " + profile.name() +
                  ", raw axes that become x, y, z: " + axes_of_map(profile.axis_map()));
  add_numbers(profile.axis_map(), lines);
  add_numbers(profile, lines);
  return lines;
}

std::string unchecked_text(const v1::DeviceInfo& info) {
  if (info.checked()) return {};
  return format("device of tool %u: %g N at most until its axes and signs are checked: ",
                info.tool_id(), info.force_limit_n()) +
         "hapticctl device check" +
         (info.tool_id() == 0 ? std::string() : " --tool " + std::to_string(info.tool_id()));
}

std::string no_force_text(const v1::DeviceInfo& info) {
  const v1::Quantity& actuated = info.profile().actuated_axes();
  const bool has_motors = actuated.value().empty() || actuated.value(0) > 0.0;
  if (info.force_limit_n() > 0.0 || !has_motors) return {};
  return format("device of tool %u: no force: the smaller of peak_force_n and --max-force is 0 N",
                info.tool_id());
}

const v1::DeviceState* device_of(const v1::State& state, std::uint32_t tool_id) {
  for (const v1::DeviceState& device : state.devices()) {
    if (device.tool_id() == tool_id) return &device;
  }
  return nullptr;
}

std::vector<std::string> reading_lines(const v1::State& state, std::optional<std::uint32_t> tool) {
  std::vector<std::string> lines{
      format("tick %llu  ", static_cast<unsigned long long>(state.tick())) +
      plain_name(v1::LoopState_Name(state.loop_state()), "LOOP_STATE_")};
  if (state.cause() != v1::CAUSE_UNSPECIFIED) lines[0] += " (" + cause_of(state) + ")";
  if (state.has_timing())
    lines[0] += format("   input age %.0f us", 1e-3 * state.timing().input_age_ns());
  for (const v1::DeviceState& device : state.devices()) {
    if (!tool || device.tool_id() == *tool) add_readings(device, state, lines);
  }
  return lines;
}

v1::State only_tool(v1::State state, std::uint32_t tool) {
  const auto other = [tool](const auto& each) { return each.tool_id() != tool; };
  auto& tools = *state.mutable_tools();
  tools.erase(std::remove_if(tools.begin(), tools.end(), other), tools.end());
  auto& devices = *state.mutable_devices();
  devices.erase(std::remove_if(devices.begin(), devices.end(), other), devices.end());
  return state;
}

std::string unready_text(const v1::State& state, std::uint32_t tool_id) {
  const v1::DeviceState* device = device_of(state, tool_id);
  if (device == nullptr) {
    return format("there is no tool %u. hapticctl device info names those that are", tool_id);
  }
  if (!has(*device, v1::DEVICE_FLAG_ATTACHED)) return "the device is gone. Plug it in";
  if (has(*device, v1::DEVICE_FLAG_EMERGENCY_STOP)) {
    return "the emergency stop is pressed. Release it, then hapticctl clear";
  }
  if (!has(*device, v1::DEVICE_FLAG_CALIBRATED)) {
    return "the device's zero is not known. hapticctl device calibrate";
  }
  if (has(*device, v1::DEVICE_FLAG_FAULT)) {
    return "the device reports a fault. See its manual, then hapticctl clear";
  }
  if (state.loop_state() == v1::LOOP_STATE_FAULT) {
    return "a fault is latched (" + cause_of(state) + "). hapticctl clear";
  }
  if (state.cause() == v1::CAUSE_DEAD_MAN) {
    return "the dead-man switch is open. Hold it during the whole check";
  }
  return {};
}

}  // namespace hapticd::ctl
