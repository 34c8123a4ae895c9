// See device_desk.h.
#include "server/daemon/device_desk.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "proto/wire/request_result.h"
#include "server/daemon/daemon_options.h"
#include "server/daemon/scene_tool.h"
#include "server/haptic_loop/device_limits.h"
#include "server/recorder/recorder_thread.h"
#include "server/scene_io/profile_loader.h"
#include "server/scene_io/sheet_translation.h"

namespace hapticd {
namespace {

using wire::result_of;

constexpr const char* kStep = "calibrate.step";
constexpr const char* kEngageFirst = "Engage first, with nothing near the tool: hapticctl engage.";

v1::Result wrong_state(const std::string& message) {
  return result_of(v1::RESULT_CODE_WRONG_STATE, kStep, message);
}

bool is_direction(v1::Axis axis) { return v1::Axis_IsValid(axis) && axis != v1::AXIS_UNSPECIFIED; }

PushAxis push_axis(v1::Axis axis) { return static_cast<PushAxis>(axis); }

/// What is wrong with a device's own word; empty: nothing.
std::string sheet_fault(const DeviceSheet& sheet) {
  const ProfileResult result = check_profile(to_profile(sheet));
  return result.loaded ? std::string() : to_text(result.problems.front());
}

void tell_damping(const MeasuredDamping& measured, v1::DeviceInfo& info) {
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!measured[i]) continue;
    v1::MeasuredDamping& told = *info.add_damping();
    told.set_axis(static_cast<v1::Axis>(1 + 2 * i));
    told.set_lower_n_s_per_m(measured[i]->lower);
    told.set_upper_n_s_per_m(measured[i]->upper);
    told.set_mass_kg(measured[i]->mass);
  }
}

void tell_attached(const AttachedDevice& attached, v1::DeviceInfo& info) {
  info.set_driver(static_cast<v1::Driver>(attached.sheet.profile.driver));
  info.set_serial(attached.attachment->serial());
  info.set_port(attached.attachment->port());
  info.set_checked(attached.check == nullptr || attached.check->passed());
  if (attached.check != nullptr) {
    for (const PushAxis axis : attached.check->confirmed()) {
      info.add_confirmed(static_cast<v1::Axis>(axis));
    }
    tell_damping(attached.check->damping(), info);
  }
  if (attached.open.calibration == nullptr) return;
  const CalibrationStatus status = attached.open.calibration->status();
  info.set_calibration(static_cast<v1::CalibrationState>(status.phase));
  info.set_calibration_progress(status.progress);
}

}  // namespace

void DeviceDesk::attach() {
  AttachOptions options;
  options.max_force = player_.max_force;
  options.checks = recordings_folder().parent_path() / "devices";
  options.installed = load_installed_profiles;
  options.fault = sheet_fault;
  for (ToolDevice& device : player_.devices) {
    if (device.source.driver->open == nullptr) continue;
    try {
      attached_.push_back(attach_device(device.source, device.sheet, options));
    } catch (const std::runtime_error& error) {
      throw StartError(kExitInput, std::string("--device: ") + error.what());
    }
    device.sheet = attached_.back().sheet;
    device.attached = attached_.back().open.device.get();
  }
}

const AttachedDevice* DeviceDesk::attached_of(std::uint32_t tool_id) const {
  const HapticDevice* device = device_of(player_, tool_id).attached;
  const auto found = std::find_if(
      attached_.begin(), attached_.end(),
      [&](const AttachedDevice& attached) { return attached.open.device.get() == device; });
  return found == attached_.end() ? nullptr : &*found;
}

PaceSource DeviceDesk::pace() const {
  const auto first =
      std::min_element(player_.devices.begin(), player_.devices.end(),
                       [](const auto& a, const auto& b) { return a.tool_id < b.tool_id; });
  const AttachedDevice* attached = attached_of(first->tool_id);
  return attached == nullptr ? PaceSource{} : attached->open.pace;
}

v1::DeviceInfo DeviceDesk::info(std::size_t k) const {
  const std::uint32_t tool_id = scenes_.newest().index.tool_ids[k];
  const ToolDevice& tool = device_of(player_, tool_id);
  v1::DeviceInfo info;
  info.set_tool_id(tool_id);
  *info.mutable_profile() = to_profile(tool.sheet);
  info.set_stiffness_bound_n_per_m(stiffness_bounds_[k]);
  info.set_force_limit_n(std::min(tool.sheet.profile.peak_force, player_.max_force));
  if (measured_delays_[k] > 0.0) info.set_measured_delay_s(measured_delays_[k]);
  if (const AttachedDevice* attached = attached_of(tool_id)) {
    tell_attached(*attached, info);
    return info;
  }
  info.set_driver(static_cast<v1::Driver>(tool.source.driver->driver));
  info.set_port("inside the daemon");
  info.set_checked(true);
  return info;
}

Answer DeviceDesk::describe() const {
  v1::Result result = result_of(v1::RESULT_CODE_OK);
  for (std::size_t k = 0; k < scenes_.newest().index.tool_ids.size(); ++k) {
    *result.mutable_devices()->add_devices() = info(k);
  }
  return result;
}

Answer DeviceDesk::calibrate(const RequestId& id, const v1::Calibrate& calibrate) {
  const std::uint32_t tool_id = calibrate.tool_id();
  if (tool_of(tool_id, scenes_.newest().index) == kNoTool) {
    return no_such_tool("calibrate.tool_id");
  }
  const v1::CalibrateStep step = calibrate.step();
  if (step == v1::CALIBRATE_STEP_UNSPECIFIED || !v1::CalibrateStep_IsValid(step)) {
    return result_of(v1::RESULT_CODE_INVALID, kStep, "Say what to do.");
  }
  const AttachedDevice* attached = attached_of(tool_id);
  // Those up to STORE are the device's own.
  if (step <= v1::CALIBRATE_STEP_STORE) {
    return attached == nullptr
               ? wrong_state("This device needs no calibration.")
               : begin_calibration(id, *attached, static_cast<CalibrationStep>(step));
  }
  if (attached == nullptr || attached->check == nullptr) {
    return wrong_state("This device needs no check: it cannot push anyone.");
  }
  return check(id, calibrate, *attached->check);
}

Answer DeviceDesk::check(const RequestId& id, const v1::Calibrate& calibrate, DeviceCheck& check) {
  const bool is_one = is_direction(calibrate.axis());
  // Felt along an axis that it cannot push along, it is wrong like any other.
  if (calibrate.step() == v1::CALIBRATE_STEP_CONFIRM && is_one) {
    return to_result(check.confirm(push_axis(calibrate.axis())));
  }
  if (!is_one || !check.has(push_axis(calibrate.axis()))) {
    return result_of(v1::RESULT_CODE_INVALID, "calibrate.axis",
                     "Give one of the directions that the device can push in.");
  }
  if (damping_.busy()) {
    return result_of(v1::RESULT_CODE_BUSY, kStep, "The damping is being measured.");
  }
  return calibrate.step() == v1::CALIBRATE_STEP_MEASURE ? measure(id, calibrate, check)
                                                        : push(id, calibrate, check);
}

// The spring of a device whose motors push the wrong way would throw the handle.
Answer DeviceDesk::measure(const RequestId& id, const v1::Calibrate& calibrate,
                           DeviceCheck& check) {
  if (!check.passed()) return wrong_state("Check its axes and directions first.");
  if (loop_.state() != LoopState::kEngaged && loop_.state() != LoopState::kFault) {
    return wrong_state(kEngageFirst);
  }
  return damping_.begin(
      id, {tool_of(calibrate.tool_id(), scenes_.newest().index), push_axis(calibrate.axis())},
      check);
}

Answer DeviceDesk::push(const RequestId& id, const v1::Calibrate& calibrate, DeviceCheck& check) {
  // Of a fault the loop says why.
  const LoopState state = loop_.state();
  if (state != LoopState::kEngaged && state != LoopState::kFault) {
    return wrong_state(kEngageFirst);
  }
  const PushCommand what{tool_of(calibrate.tool_id(), scenes_.newest().index),
                         push_axis(calibrate.axis())};
  const AskedPush asked{loop_.next_number(), &check, what.axis};
  Answer refused = loop_.command(id, what);
  if (!refused) push_ = asked;
  return refused;
}

Answer DeviceDesk::begin_calibration(const RequestId& id, const AttachedDevice& attached,
                                     CalibrationStep step) {
  Calibration* calibration = attached.open.calibration.get();
  if (calibration == nullptr || !calibration->needed()) {
    return wrong_state("This device needs no calibration.");
  }
  const LoopState state = loop_.state();
  if (state == LoopState::kEngaged || state == LoopState::kReleasing) {
    return wrong_state("Not while there may be force: hapticctl disengage, then try again.");
  }
  if (!calibration->ask(step)) {
    return result_of(v1::RESULT_CODE_BUSY, kStep,
                     "The device has not answered the previous step yet.");
  }
  calibrations_.push_back({id, calibration});
  return std::nullopt;
}

void DeviceDesk::take(const LoopEvent& event) {
  damping_.take(event);
  const auto* done = std::get_if<CommandDone>(&event.what);
  if (done == nullptr || !push_ || push_->number != done->number) return;
  push_->check->note_push(push_->axis, event.t_ns);
  push_.reset();
}

void DeviceDesk::take(const Tick& tick) {
  damping_.take(tick);
  for (std::size_t k = 0; k < tick.tools.size(); ++k) {
    stiffness_bounds_[k] = tick.tools[k].stiffness.bound;
    measured_delays_[k] = tick.tools[k].sample.measured_delay_s;
  }
  if (tick.state == LoopState::kEngaged) return;
  for (const AttachedDevice& attached : attached_) {
    if (attached.check != nullptr) attached.check->note_no_force(tick.t_ns);
  }
}

void DeviceDesk::watch_forces(const Tick& tick) {
  for (std::size_t k = 0; k < tick.tools.size(); ++k) {
    const ToolTick& tool = tick.tools[k];
    const StiffnessTick& stiffness = tool.stiffness;
    const ToolDevice& device = device_of(player_, tool.tool_id);
    const DeviceProfile& profile = device.sheet.profile;
    const bool unmeasured =
        profile.damping_guessed && reaches_a_hand(profile, device.source.driver->traits);
    const auto line = force_watch_.look(
        tick.scene_id, k,
        {tool.tool_id, stiffness.scale, stiffness.bound, stiffness.delay, unmeasured}, profile,
        player_.max_force);
    if (line) spdlog::warn("{}", *line);
  }
}

void DeviceDesk::work() {
  std::erase_if(calibrations_, [this](const AskedCalibration& asked) {
    const std::optional<std::string> error = asked.calibration->take_answer();
    if (!error) return false;
    clients_.answer(asked.request,
                    error->empty() ? result_of(v1::RESULT_CODE_OK)
                                   : result_of(v1::RESULT_CODE_FAILED, kStep,
                                               "The device cannot do that now: " + *error + "."));
    return true;
  });
}

}  // namespace hapticd
