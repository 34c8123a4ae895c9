// Which devices have passed the guided check, as small files, one for each serial number. A file
// counts only when it is, to the byte, what would be written for this device now: it holds a hash
// of all that the check depended on. Anything else is a device that was not checked. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "device/api/axis_mapping.h"
#include "device/report_io/hidraw_nodes.h"

namespace hapticd {

/// BLAKE2b-256.
using Fingerprint = std::array<std::uint8_t, 32>;

/// A device as a check knows it again.
struct CheckedDevice {
  std::string serial;  ///< empty: it has none, and cannot be known again
  std::string product;
  Fingerprint fingerprint{};  ///< of what the check depends on
};

/// The device of `node`. `stated`: what it says of itself, byte for byte; `axes`: of its profile.
[[nodiscard]] CheckedDevice checked_device(const HidrawNode& node,
                                           std::span<const std::uint8_t> stated,
                                           const AxisMapping& axes);

/// The file of that kind, ".check" or the like, for `device` in `folder`.
[[nodiscard]] std::filesystem::path record_file(const std::filesystem::path& folder,
                                                const CheckedDevice& device, std::string_view kind);

/// First lines of a record: what it `says`, as comments, and of which serial.
[[nodiscard]] std::string record_head(const CheckedDevice& device, std::string_view says);
/// Those, and the product and the fingerprint: what a record of this device begins with.
[[nodiscard]] std::string record_start(const CheckedDevice& device, std::string_view says);

/// The file for `device` in `folder` that says that its check was passed.
[[nodiscard]] std::filesystem::path check_file(const std::filesystem::path& folder,
                                               const CheckedDevice& device);

/// True when `folder` has the file that remember_check() writes. Says in the log why another file
/// does not count, and what to do.
[[nodiscard]] bool is_remembered(const std::filesystem::path& folder, const CheckedDevice& device);

/// Keeps, beyond a loss of power, that the check was passed. Makes the folder. Throws
/// std::runtime_error with file, reason and remedy.
void remember_check(const std::filesystem::path& folder, const CheckedDevice& device);

/// Undoes it; throws likewise.
void forget_check(const std::filesystem::path& folder, const CheckedDevice& device);

}  // namespace hapticd
