// See outside_device.h.
#include "server/devices/outside_device.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "core/rt/monotonic_clock.h"
#include "device/hid/device_features.h"
#include "device/hid/hid_device.h"
#include "device/hid/profile_codec.h"
#include "device/hid/profile_units.h"
#include "device/hid/report_descriptor.h"
#include "device/spacemouse/spacemouse_device.h"
#include "server/devices/pid_attachment.h"
#include "server/devices/profile_numbers.h"

namespace hapticd {
namespace {

std::int64_t now() noexcept { return monotonic_now_ns(); }

bool is_hid(const HidrawNode& node) { return is_profile_v1(hid::read_descriptor(node.descriptor)); }

bool is_spacemouse(const HidrawNode& node) {
  return spacemouse::is_spacemouse(node.vendor_id, node.product_id);
}

/// The workspace, stated along the device's own axes, along those of D.
void turn_workspace(const AxisMapping& axes, DeviceProfile& stated) {
  const Array3 one = position_in_base(axes, stated.workspace_lower);
  const Array3 other = position_in_base(axes, stated.workspace_upper);
  for (std::size_t i = 0; i < 3; ++i) {
    std::tie(stated.workspace_lower[i], stated.workspace_upper[i]) =
        std::minmax({one[i], other[i]});
  }
}

/// The driver of a device of the HID profile, as its keeper wants it.
KeptDriver kept(hid::HidDevice& device, DeviceCalibration& calibration,
                const hid::Capabilities& known, double force, double torque) {
  KeptDriver driver;
  driver.mine = is_hid;
  driver.attach = [&device, &calibration, known, force, torque](const HidrawNode& node,
                                                                const ReportChannel& channel) {
    constexpr const char* kAgain = "Plug it in again.";
    std::string error;
    hid::Capabilities capabilities;
    if (!get_capabilities(channel, capabilities, error)) throw DeviceError(node, error, kAgain);
    if (!(capabilities == known)) {
      throw DeviceError(node, "it is a different device with the same serial as before",
                        "Restart hapticd to use it.");
    }
    hid::SessionLimits limits;
    limits.force = force;
    limits.torque = torque;
    hid::Config config = hid::to_config(limits, capabilities);
    if (!agree(channel, config, error)) throw DeviceError(node, error, kAgain);
    calibration.begin(channel);
    device.attach(channel);
  };
  driver.detach = [&device, &calibration] {
    calibration.end();
    device.detach();
  };
  driver.failed = [&device] { return device.failed(); };
  driver.tend = [&calibration](HidrawHandles& handles) {
    calibration.tend([&handles] { return handles.features(); }, now());
  };
  return driver;
}

/// Which axes of its own it can push along.
std::array<bool, 3> pushes_along(const hid::Capabilities& capabilities) {
  const auto has = [&](unsigned axis) {
    return (capabilities.dof >> (hid::kForceBit + axis) & 1U) != 0;
  };
  return {has(0), has(1), has(2)};
}

OutsideDevice attach_hid(const std::string& serial, const v1::DeviceProfile& base, double max_force,
                         const std::filesystem::path& checks) {
  const HidrawNode node = find_node(is_hid, serial, "hid");
  auto handles = std::make_unique<HidrawHandles>(node);
  std::string error;
  hid::Capabilities capabilities;
  if (!get_capabilities(handles->channel(), capabilities, error)) {
    throw DeviceError(node, error, "Ask its maker for firmware of profile version 1.");
  }
  v1::DeviceProfile profile = profile_of(capabilities, node, base);
  OutsideDevice outside;
  outside.check = check_of(node, hid::encode(capabilities), pushes_along(capabilities),
                           profile_to_check(profile), checks);
  if (!outside.check->passed()) {
    limit(profile, "peak_force_n", kUncheckedForce, "nobody has checked its axes and signs");
  }
  outside.profile = checked(profile);
  const DeviceProfile& numbers = outside.profile.profile;
  const double force = std::min(max_force, numbers.peak_force);
  spdlog::info("{}: force limited to {} N{}", describe(node), force,
               outside.check->passed() ? "" : " until it is checked: hapticctl device check");
  const AxisMapping& axes = outside.profile.axes;
  auto device = std::make_unique<hid::HidDevice>(numbers, capabilities, now, axes);
  outside.calibration =
      std::make_unique<DeviceCalibration>((capabilities.caps & hid::kNeedsCalibration) != 0);
  // The device cuts in units of its own.
  const double told = force / *std::max_element(axes.force_scale.begin(), axes.force_scale.end());
  outside.keeper = std::make_unique<DeviceKeeper>(
      kept(*device, *outside.calibration, capabilities, told, numbers.peak_torque), node,
      std::move(handles));
  outside.pace = device->pace();
  outside.device = std::move(device);
  return outside;
}

OutsideDevice attach_spacemouse(const std::string& serial, const v1::DeviceProfile& base) {
  const HidrawNode node = find_node(is_spacemouse, serial, "spacemouse");
  OutsideDevice outside;
  outside.profile = checked(base);
  spacemouse::SpacemouseSettings settings;
  settings.axes = outside.profile.axes;
  auto device = std::make_unique<spacemouse::SpacemouseDevice>(outside.profile.profile, settings);
  KeptDriver driver;
  driver.mine = is_spacemouse;
  driver.attach = [raw = device.get()](const HidrawNode&, const ReportChannel& channel) {
    raw->attach(channel);
  };
  driver.detach = [raw = device.get()] { raw->detach(); };
  driver.failed = [raw = device.get()] { return raw->failed(); };
  outside.keeper = std::make_unique<DeviceKeeper>(std::move(driver), node,
                                                  std::make_unique<HidrawHandles>(node));
  outside.device = std::move(device);
  return outside;
}

}  // namespace

std::optional<OutsideSource> outside_source(std::string_view source) {
  static const std::array<OutsideSource, 3> kinds{
      {{DeviceDriver::kHid, "hid", "", "hid_v1"},
       {DeviceDriver::kPid, "pid", "", kGenericPid},
       {DeviceDriver::kSpacemouse, "spacemouse", "", "spacemouse"}}};
  for (const OutsideSource& kind : kinds) {
    if (source == kind.kind) return kind;
    if (source.size() <= kind.kind.size() + 1 || !source.starts_with(kind.kind + ":")) continue;
    OutsideSource named = kind;
    named.serial = source.substr(kind.kind.size() + 1);
    return named;
  }
  return std::nullopt;
}

OutsideDevice attach_device(const OutsideSource& source, const v1::DeviceProfile& base,
                            double max_force, const std::filesystem::path& checks) {
  if (source.driver == DeviceDriver::kSpacemouse) return attach_spacemouse(source.serial, base);
  if (source.driver == DeviceDriver::kPid) {
    return attach_pid(source.serial, base, max_force, checks);
  }
  return attach_hid(source.serial, base, max_force, checks);
}

v1::DeviceProfile profile_of(const hid::Capabilities& capabilities, const HidrawNode& node,
                             const v1::DeviceProfile& base) {
  DeviceProfile stated;
  hid::apply_capabilities(capabilities, stated);
  if (const ProfileResult chosen = check_profile(base); chosen.loaded) {
    turn_workspace(chosen.loaded->axes, stated);
  }
  v1::DeviceProfile profile = base;
  profile.set_driver(v1::DRIVER_HID);
  // What bears no stiffness that it tells of refuses all of them.
  const bool affine = (capabilities.caps & hid::kCanAffine) != 0 && capabilities.k_max_npm > 0;
  if (profile.affine() && !affine) {
    spdlog::warn("{}: no affine commands, which its profile asks for", describe(node));
  }
  profile.set_affine(profile.affine() && affine);
  if (profile.description().empty()) profile.set_description(describe(node));
  fill(profile, "sensed_axes", {static_cast<double>(stated.sensed_axes)});
  fill(profile, "actuated_axes", {static_cast<double>(stated.actuated_axes)});
  limit(profile, "peak_force_n", stated.peak_force);
  limit(profile, "peak_torque_n_m", stated.peak_torque);
  limit(profile, "continuous_force_n", stated.continuous_force);
  limit(profile, "continuous_torque_n_m", stated.continuous_torque);
  limit(profile, "stiffness_max_n_per_m", stated.stiffness_max);
  const Array3& low = stated.workspace_lower;
  const Array3& high = stated.workspace_upper;
  if (std::all_of(low.begin(), low.end(), [](double v) { return std::isfinite(v); })) {
    fill(profile, "workspace_lower_m", {low[0], low[1], low[2]});
    fill(profile, "workspace_upper_m", {high[0], high[1], high[2]});
  }
  fill(profile, "report_rate_hz", {stated.report_rate});
  fill(profile, "watchdog_s", {stated.watchdog});
  return profile;
}

}  // namespace hapticd
