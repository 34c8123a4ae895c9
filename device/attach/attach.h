// Attaches a device that is plugged in: finds it, opens it, has it checked and limited, and keeps
// it attached. Not RT; the device is as HapticDevice says.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "device/attach/attachment.h"
#include "device/attach/device_check.h"
#include "device/attach/drivers.h"

namespace hapticd {

/// What attaching needs to know of its surroundings.
struct AttachOptions {
  double max_force = kUnlimited;  ///< that a device may be told to give, N
  std::filesystem::path checks;   ///< the folder where passed checks are kept
  /// The profiles of this machine.
  std::function<std::vector<DeviceSheet>()> installed;
  /// What is wrong with a sheet that holds a device's own word; empty: nothing.
  std::function<std::string(const DeviceSheet&)> fault;
};

/// A device that is plugged in, and kept attached as long as this.
struct AttachedDevice {
  DeviceSheet sheet;  ///< what holds of this device
  OpenDevice open;
  std::unique_ptr<DeviceCheck> check;      ///< null: it pushes nobody
  std::unique_ptr<Attachment> attachment;  ///< last: it ends before the device does
};

/// Takes what `check` knows of the damping for that of `sheet`, where that is a guess, not
/// stated, or more than was found at most. Changes nothing while an axis that it pushes along has
/// not been measured.
void count_damping(const DeviceCheck& check, DeviceSheet& sheet);

/// Attaches the device that `source` names, which is one for what is plugged in. `chosen`: the
/// profile for it. It gets `max_force` at most, and no more than kUncheckedForce unless it has been
/// checked. Throws std::runtime_error with what is wrong and the remedy.
[[nodiscard]] AttachedDevice attach_device(const DeviceSource& source, const DeviceSheet& chosen,
                                           const AttachOptions& options);

}  // namespace hapticd
