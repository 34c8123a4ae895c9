// Devices outside the process: attached at the start, kept so; and what is told of
// any device. See daemon.h.
#include "server/daemon/daemon.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "proto/wire/request_result.h"

namespace hapticd {
namespace {

v1::CalibrationState state_of(CalibrationPhase phase) {
  switch (phase) {
    case CalibrationPhase::kNeeded:
      return v1::CALIBRATION_STATE_NEEDED;
    case CalibrationPhase::kRunning:
      return v1::CALIBRATION_STATE_RUNNING;
    case CalibrationPhase::kDone:
      return v1::CALIBRATION_STATE_DONE;
    case CalibrationPhase::kFailed:
      return v1::CALIBRATION_STATE_FAILED;
    case CalibrationPhase::kUnknown:
      break;
  }
  return v1::CALIBRATION_STATE_UNSPECIFIED;
}

}  // namespace

void Daemon::attach_devices() {
  const std::filesystem::path checks = recordings_folder().parent_path() / "devices";
  for (ToolDevice& device : plan_.player.devices) {
    const std::optional<OutsideSource> source = outside_source(device.source);
    if (!source) continue;
    try {
      outside_.push_back(
          attach_device(*source, device.profile.message, plan_.player.max_force, checks));
    } catch (const std::runtime_error& error) {
      throw StartError(kExitInput, std::string("--device: ") + error.what());
    }
    device.profile = outside_.back().profile;
    device.attached = outside_.back().device.get();
  }
}

const OutsideDevice* Daemon::outside_of(std::uint32_t tool_id) const {
  const HapticDevice* device = device_of(plan_.player, tool_id).attached;
  const auto found =
      std::find_if(outside_.begin(), outside_.end(),
                   [&](const OutsideDevice& outside) { return outside.device.get() == device; });
  return found == outside_.end() ? nullptr : &*found;
}

PaceSource Daemon::pace_source() const {
  const auto first =
      std::min_element(plan_.player.devices.begin(), plan_.player.devices.end(),
                       [](const auto& a, const auto& b) { return a.tool_id < b.tool_id; });
  const OutsideDevice* outside = outside_of(first->tool_id);
  return outside == nullptr ? PaceSource{} : outside->pace;
}

v1::DeviceInfo Daemon::device_info(std::size_t k) const {
  const std::uint32_t tool_id = scenes_.newest().index.tool_ids[k];
  const ToolDevice& tool = device_of(plan_.player, tool_id);
  v1::DeviceInfo info;
  info.set_tool_id(tool_id);
  *info.mutable_profile() = tool.profile.message;
  info.set_stiffness_bound_n_per_m(stiffness_bounds_[k]);
  info.set_force_limit_n(std::min(tool.profile.profile.peak_force, plan_.player.max_force));
  if (measured_delays_[k] > 0.0) info.set_measured_delay_s(measured_delays_[k]);
  const OutsideDevice* outside = outside_of(tool_id);
  if (outside == nullptr) {
    info.set_driver(tool.source == "scripted" ? v1::DRIVER_SCRIPTED
                    : tool.source == "replay" ? v1::DRIVER_REPLAY
                                              : v1::DRIVER_SIMULATED);
    info.set_port("inside the daemon");
    info.set_checked(true);
    return info;
  }
  info.set_driver(tool.profile.message.driver());
  info.set_serial(outside->keeper->serial());
  info.set_port(outside->keeper->port());
  info.set_checked(outside->check == nullptr || outside->check->passed());
  if (outside->check != nullptr) {
    for (const PushAxis axis : outside->check->confirmed()) {
      info.add_confirmed(static_cast<v1::Axis>(axis));
    }
  }
  if (outside->calibration != nullptr) {
    const CalibrationStatus status = outside->calibration->status();
    info.set_calibration(state_of(status.phase));
    info.set_calibration_progress(status.progress);
  }
  return info;
}

Answer Daemon::describe_devices() const {
  v1::Result result = wire::result_of(v1::RESULT_CODE_OK);
  const std::vector<std::uint32_t>& tool_ids = scenes_.newest().index.tool_ids;
  for (std::size_t k = 0; k < tool_ids.size(); ++k) {
    *result.mutable_devices()->add_devices() = device_info(k);
  }
  return result;
}

// A replay feels nothing.
void Daemon::watch_forces(const Snapshot& snapshot) {
  if (replays()) return;
  for (std::size_t k = 0; k < snapshot.tools.size(); ++k) {
    const ToolReading& tool = snapshot.tools[k];
    const auto line = force_watch_.look(
        snapshot.scene_id, k,
        {tool.tool_id, tool.stiffness_scale, tool.stiffness_bound, tool.delay},
        device_of(plan_.player, tool.tool_id).profile.profile, plan_.player.max_force);
    if (line) spdlog::warn("{}", *line);
  }
}

}  // namespace hapticd
