// The driver of devices of the HID profile. Not RT.
#pragma once

#include "device/api/driver.h"
#include "device/hid/profile_v1.h"

namespace hapticd::hid {

/// Its report descriptor is that of the profile.
[[nodiscard]] bool is_mine(const HidrawNode& node);

/// `chosen` with what a device of the HID profile says of itself in place of what `chosen` leaves
/// open; limits are the lower of both.
[[nodiscard]] DeviceSheet stated_sheet(const Capabilities& capabilities, const HidrawNode& node,
                                       const DeviceSheet& chosen);

/// Tells the device to give no more than it is granted.
[[nodiscard]] OpenDevice open(const FoundDevice& found);

inline constexpr DriverEntry kDriver{.kind = "hid",
                                     .driver = DeviceDriver::kHid,
                                     .what = "haptic device",
                                     .argument = SourceArgument::kSerial,
                                     .profile = "hid_v1",
                                     .on_time = true,
                                     .mine = is_mine,
                                     .open = open};

}  // namespace hapticd::hid
