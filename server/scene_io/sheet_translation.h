// Device profiles of the protocol to sheets of the drivers and back, nothing lost on the way. Not
// RT.
#pragma once

#include "device/api/device_sheet.h"
#include "hapticd/v1/device_profile.pb.h"

namespace hapticd {

/// The sheet of a profile that check_profile() has found no fault in.
[[nodiscard]] DeviceSheet to_sheet(const v1::DeviceProfile& profile);

/// The profile that a sheet is.
[[nodiscard]] v1::DeviceProfile to_profile(const DeviceSheet& sheet);

}  // namespace hapticd
