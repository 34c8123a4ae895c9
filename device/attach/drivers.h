// The drivers of hapticd, and which one a source or a plugged-in device is for. Not RT.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "device/api/driver.h"

namespace hapticd {

/// All of them. Where two can drive the same device, the first does.
[[nodiscard]] std::span<const DriverEntry> drivers() noexcept;

[[nodiscard]] const DriverEntry& driver_entry(DeviceDriver driver) noexcept;

/// A source as --device has it: "simulated", "replay:FILE", "hid", "hid:SERIAL" and so on.
struct DeviceSource {
  const DriverEntry* driver = nullptr;  ///< never null
  std::string argument;                 ///< behind the colon; may be empty
};

/// None: no driver is meant.
[[nodiscard]] std::optional<DeviceSource> parse_source(std::string_view source);

/// The driver for what is plugged in; null: there is none.
[[nodiscard]] const DriverEntry* driver_for(const HidrawNode& node);

/// The driver that was behind a recorded device: that of its source, or, of what was plugged in,
/// the one that its profile names.
[[nodiscard]] DeviceDriver recorded_driver(std::string_view source, const DeviceProfile& profile);

}  // namespace hapticd
