// Makes a device that lives inside the process. Offline: allocates.
#pragma once

#include <memory>
#include <variant>

#include "device/replay/replay_device.h"
#include "device/scripted/scripted_device.h"
#include "device/simulated/simulated_device.h"

namespace hapticd {

/// A device that was.
struct ReplayOptions {
  DeviceDriver driver = DeviceDriver::kReplay;  ///< of the device recorded: it is treated as that
};

/// What drives a device: the alternative chosen is the driver.
using DeviceOptions = std::variant<SimulatedOptions, ScriptedOptions, ReplayOptions>;

/// The device of `profile`'s numbers with the driver that `options` names, whatever the
/// profile names: a scripted session may have the limits of any device.
[[nodiscard]] std::unique_ptr<HapticDevice> make_device(const DeviceProfile& profile,
                                                        const DeviceOptions& options);

}  // namespace hapticd
