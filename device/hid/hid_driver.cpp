// See hid_driver.h.
#include "device/hid/hid_driver.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/rt/monotonic_clock.h"
#include "device/hid/calibration.h"
#include "device/hid/device_features.h"
#include "device/hid/hid_device.h"
#include "device/hid/profile_codec.h"
#include "device/hid/profile_units.h"
#include "device/hid/report_descriptor.h"
#include "device/report_io/hidraw_handles.h"

namespace hapticd::hid {
namespace {

std::int64_t now() noexcept { return monotonic_now_ns(); }

/// The workspace, stated along the device's own axes, along those of D.
void turn_workspace(const AxisMapping& axes, DeviceProfile& stated) {
  const Array3 one = position_in_base(axes, stated.workspace_lower);
  const Array3 other = position_in_base(axes, stated.workspace_upper);
  for (std::size_t i = 0; i < 3; ++i) {
    std::tie(stated.workspace_lower[i], stated.workspace_upper[i]) =
        std::minmax({one[i], other[i]});
  }
}

/// Which axes of its own it can push along.
std::array<bool, 3> pushes_along(const Capabilities& capabilities) {
  const auto has = [&](unsigned axis) {
    return (capabilities.dof >> (kForceBit + axis) & 1U) != 0;
  };
  return {has(0), has(1), has(2)};
}

/// What was agreed on with the device, and holds when it is plugged in again.
struct Agreed {
  Capabilities capabilities;
  SessionLimits limits;
};

class HidPlug final : public Plug {
 public:
  HidPlug(HidDevice& device, DeviceCalibration& calibration, Agreed agreed)
      : device_(device), calibration_(calibration), agreed_(agreed) {}

  [[nodiscard]] std::string attach(const HidrawNode& node, const ReportChannel& channel) override {
    constexpr const char* kAgain = "Plug it in again.";
    std::string error;
    Capabilities capabilities;
    if (!get_capabilities(channel, capabilities, error)) throw DeviceError(node, error, kAgain);
    if (!(capabilities == agreed_.capabilities)) {
      throw DeviceError(node, "it is a different device with the same serial as before",
                        "Restart hapticd to use it.");
    }
    Config config = to_config(agreed_.limits, capabilities);
    if (!agree(channel, config, error)) throw DeviceError(node, error, kAgain);
    calibration_.begin(channel);
    device_.attach(channel);
    return "";
  }
  void detach() override {
    calibration_.end();
    device_.detach();
  }
  [[nodiscard]] bool failed() const noexcept override { return device_.failed(); }
  void tend(const std::function<ReportChannel()>& features) override {
    calibration_.tend(features, now());
  }

 private:
  HidDevice& device_;
  DeviceCalibration& calibration_;
  Agreed agreed_;
};

}  // namespace

bool is_mine(const HidrawNode& node) { return is_profile_v1(read_descriptor(node.descriptor)); }

DeviceSheet stated_sheet(const Capabilities& capabilities, const HidrawNode& node,
                         const DeviceSheet& chosen) {
  DeviceProfile stated;
  apply_capabilities(capabilities, stated);
  turn_workspace(chosen.axes, stated);
  DeviceSheet sheet = chosen;
  sheet.profile.driver = DeviceDriver::kHid;
  // What bears no stiffness that it tells of refuses all of them.
  const bool affine = (capabilities.caps & kCanAffine) != 0 && capabilities.k_max_npm > 0;
  sheet.profile.affine = chosen.profile.affine && affine;
  if (sheet.description.empty()) sheet.description = describe(node);
  fill(sheet, &DeviceProfile::sensed_axes, {static_cast<double>(stated.sensed_axes)});
  fill(sheet, &DeviceProfile::actuated_axes, {static_cast<double>(stated.actuated_axes)});
  limit(sheet, &DeviceProfile::peak_force, stated.peak_force);
  limit(sheet, &DeviceProfile::peak_torque, stated.peak_torque);
  limit(sheet, &DeviceProfile::continuous_force, stated.continuous_force);
  limit(sheet, &DeviceProfile::continuous_torque, stated.continuous_torque);
  limit(sheet, &DeviceProfile::stiffness_max, stated.stiffness_max);
  const Array3& low = stated.workspace_lower;
  const Array3& high = stated.workspace_upper;
  if (std::all_of(low.begin(), low.end(), [](double v) { return std::isfinite(v); })) {
    fill(sheet, &DeviceProfile::workspace_lower, {low[0], low[1], low[2]});
    fill(sheet, &DeviceProfile::workspace_upper, {high[0], high[1], high[2]});
  }
  fill(sheet, &DeviceProfile::report_rate, {stated.report_rate});
  fill(sheet, &DeviceProfile::watchdog, {stated.watchdog});
  return sheet;
}

OpenDevice open(const FoundDevice& found) {
  std::string error;
  Capabilities capabilities;
  if (!get_capabilities(found.channel, capabilities, error)) {
    throw DeviceError(found.node, error, "Ask its maker for firmware of profile version 1.");
  }
  const DeviceSheet stated = stated_sheet(capabilities, found.node, found.chosen);
  const auto word = encode(capabilities);
  const DeviceGrant granted =
      found.grant({stated, {word.begin(), word.end()}, pushes_along(capabilities)});
  const DeviceProfile& numbers = granted.sheet.profile;
  const AxisMapping& axes = granted.sheet.axes;
  OpenDevice opened;
  if (found.chosen.profile.affine && !numbers.affine) {
    opened.warnings.emplace_back("no affine commands, which its profile asks for");
  }
  auto device = std::make_unique<HidDevice>(numbers, capabilities, now, axes);
  auto calibration =
      std::make_unique<DeviceCalibration>((capabilities.caps & kNeedsCalibration) != 0);
  SessionLimits limits;
  // The device cuts in units of its own.
  limits.force =
      granted.force / *std::max_element(axes.force_scale.begin(), axes.force_scale.end());
  limits.torque = numbers.peak_torque;
  opened.plug = std::make_unique<HidPlug>(*device, *calibration, Agreed{capabilities, limits});
  opened.pace = device->pace();
  opened.calibration = std::move(calibration);
  opened.device = std::move(device);
  return opened;
}

}  // namespace hapticd::hid
