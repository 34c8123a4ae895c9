// Numbers of a device's profile that the device, or what is not known of it, decides. Not RT.
#pragma once

#include <initializer_list>
#include <string>

#include "server/devices/device_check.h"
#include "server/scene_io/profile_loader.h"

namespace hapticd {

/// Source of a number that the device states of itself.
inline constexpr const char* kStated = "the device's capabilities";

/// States the number `name` of the device where the profile has none.
void fill(v1::DeviceProfile& profile, const std::string& name,
          std::initializer_list<double> values);

/// The lower one of the profile's limit `name` and `most`; infinite (kUnlimited): there is none. 0
/// is a limit: a device that states a peak force of 0 gives none.
void limit(v1::DeviceProfile& profile, const std::string& name, double most,
           const char* source = kStated);

/// What the guided check of such a device depends on; throws as checked() does.
[[nodiscard]] CheckedProfile profile_to_check(const v1::DeviceProfile& profile);

/// Throws std::runtime_error when the numbers make no profile.
[[nodiscard]] LoadedProfile checked(const v1::DeviceProfile& profile);

}  // namespace hapticd
