// What has been measured of a device's damping, kept beside the record of its check and by the same
// rule: a file counts only when it is, to the byte, what would be written for this device now.
// Anything else is a device whose damping nobody has measured; it is left as it is until the device
// is measured again. Not RT.
#pragma once

#include <array>
#include <filesystem>
#include <optional>

#include "device/attach/check_record.h"
#include "device/attach/damping_fit.h"

namespace hapticd {

/// Along x, y, z of D; empty: not measured.
using MeasuredDamping = std::array<std::optional<DampingBounds>, 3>;

/// The file for `device` in `folder`.
[[nodiscard]] std::filesystem::path damping_file(const std::filesystem::path& folder,
                                                 const CheckedDevice& device);

/// What was kept of `device`. Says in the log why a file does not count, and what to do.
[[nodiscard]] MeasuredDamping read_damping(const std::filesystem::path& folder,
                                           const CheckedDevice& device);

/// Keeps it, beyond a loss of power. Makes the folder. Throws std::runtime_error with file, reason
/// and remedy.
void keep_damping(const std::filesystem::path& folder, const CheckedDevice& device,
                  const MeasuredDamping& measured);

}  // namespace hapticd
