// Makes a device that lives inside the process. Offline: allocates.
#pragma once

#include <memory>
#include <variant>

#include "device/simulated/replay_device.h"
#include "device/simulated/scripted_device.h"
#include "device/simulated/simulated_device.h"

namespace hapticd {

/// What drives a device: the alternative chosen is the driver.
using DeviceOptions =
    std::variant<SimulatedOptions, ScriptedOptions, std::span<const DeviceSample>>;

/// The device of `profile`'s numbers with the driver that `options` stands for, whatever the
/// profile names: a scripted session may have the limits of any device. Samples of a replay must
/// outlive it.
[[nodiscard]] std::unique_ptr<HapticDevice> make_device(const DeviceProfile& profile,
                                                        const DeviceOptions& options);

}  // namespace hapticd
