// A device outside the process, of whatever driver, attached and kept attached. Not RT; `device` is
// as HapticDevice says.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "device/api/haptic_device.h"
#include "device/api/pace_source.h"
#include "device/hid/profile_v1.h"
#include "server/devices/device_calibration.h"
#include "server/devices/device_check.h"
#include "server/devices/device_keeper.h"
#include "server/scene_io/profile_loader.h"

namespace hapticd {

/// A source as --device has it: "hid", "hid:SERIAL" and so on.
struct OutsideSource {
  DeviceDriver driver = DeviceDriver::kHid;
  std::string kind;     ///< before the colon
  std::string serial;   ///< empty: the only one there is
  std::string profile;  ///< of every such device that no other is for, by name
};

/// None: the source is no device outside the process.
[[nodiscard]] std::optional<OutsideSource> outside_source(std::string_view source);

struct OutsideDevice {
  LoadedProfile profile;  ///< of this device
  std::unique_ptr<HapticDevice> device;
  std::unique_ptr<DeviceCheck> check;              ///< null: it pushes nobody
  std::unique_ptr<DeviceCalibration> calibration;  ///< of `device`; null: it has none
  std::unique_ptr<DeviceKeeper> keeper;            ///< of `device`
  PaceSource pace;                                 ///< of `device`, where it sends reports on time
};

/// Attaches it. `base`: the profile chosen for it; `max_force`: what it is told to give at most, N,
/// and no more than kUncheckedForce unless the folder `checks` says that it was checked. Throws
/// std::runtime_error with what is wrong and the remedy.
[[nodiscard]] OutsideDevice attach_device(const OutsideSource& source,
                                          const v1::DeviceProfile& base, double max_force,
                                          const std::filesystem::path& checks);

/// `base` with what a device of the HID profile says of itself in place of what `base` leaves open;
/// limits are the lower of both. Each number names its source.
[[nodiscard]] v1::DeviceProfile profile_of(const hid::Capabilities& capabilities,
                                           const HidrawNode& node, const v1::DeviceProfile& base);

}  // namespace hapticd
