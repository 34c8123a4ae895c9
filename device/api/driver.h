// What a driver is to the rest of hapticd: one DriverEntry, with which a device is told to be its
// own, opened, or made. A folder of device/ has one, and device/attach/drivers.cpp lists it. Not
// RT.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/pose.h"
#include "device/api/calibration.h"
#include "device/api/device_facets.h"
#include "device/api/device_sheet.h"
#include "device/api/haptic_device.h"
#include "device/api/hidraw_node.h"
#include "device/api/pace_source.h"
#include "device/api/report_channel.h"

namespace hapticd {

/// A device that may be unplugged and plugged in again, as seen by what keeps it attached. All but
/// failed() are called by one thread at a time.
class Plug {
 public:
  Plug() = default;
  Plug(const Plug&) = delete;
  Plug& operator=(const Plug&) = delete;
  Plug(Plug&&) = delete;
  Plug& operator=(Plug&&) = delete;
  virtual ~Plug() = default;

  /// Makes an open device ready and lets the loop at it. Returns what people should be warned of;
  /// empty: of nothing. Throws DeviceError where it is another device, or refuses.
  [[nodiscard]] virtual std::string attach(const HidrawNode& node,
                                           const ReportChannel& channel) = 0;
  /// Returns when the loop is not at it.
  virtual void detach() = 0;
  /// The device is gone. Any thread.
  [[nodiscard]] virtual bool failed() const noexcept = 0;
  /// Between two looks, while it is attached. `features` gives a channel for features that no other
  /// thread uses, or throws std::runtime_error. May wait for seconds.
  virtual void tend(const std::function<ReportChannel()>& features) { static_cast<void>(features); }
};

/// A device that can be played.
struct OpenDevice {
  std::unique_ptr<HapticDevice> device;
  DeviceFacets facets;                       ///< of `device`
  std::unique_ptr<Calibration> calibration;  ///< of `device`; null: it has none
  std::unique_ptr<Plug> plug;                ///< of `device`; null: it is inside the process
  PaceSource pace;                           ///< of `device`, where it sends reports on time
  std::vector<std::string> warnings;         ///< of what people should know, one line each
};

/// What a driver has found out of a device that pushes.
struct DeviceStatement {
  DeviceSheet sheet;                   ///< the profile, with what the device says of itself
  std::vector<std::uint8_t> identity;  ///< its word to the byte: another one is another device
  std::array<bool, 3> push_axes{};     ///< along which axes of its own, x y z, it can push
};

/// What a device is allowed.
struct DeviceGrant {
  DeviceSheet sheet;   ///< limits lowered where nobody has checked the device
  double force = 0.0;  ///< that it will be told to give at most, N
};

/// A device that is plugged in, open and nobody else's, for its driver to look at.
struct FoundDevice {
  const HidrawNode& node;
  ReportChannel channel;
  const DeviceSheet& chosen;  ///< the profile for it
  /// All profiles of this machine, for drivers that choose a better one.
  std::function<std::vector<DeviceSheet>()> installed;
  /// To be called once, before the device is made, by drivers of devices that push. Throws
  /// std::runtime_error where the numbers make no profile.
  std::function<DeviceGrant(const DeviceStatement&)> grant;
};

/// How a device inside the process is played.
struct InsideOptions {
  Pose X_DH{};                                    ///< where the handle begins, at rest
  bool virtual_time = false;                      ///< else a tick without a pose brings no sample
  ArmKind arm = ArmKind::kLight;                  ///< that holds it, where one does
  std::uint64_t seed = 1;                         ///< of the arm's tremor
  DeviceDriver recorded = DeviceDriver::kReplay;  ///< of a replay: the driver that was there
};

/// What follows the kind of a device in the source that is asked for.
enum class SourceArgument : std::uint8_t {
  kNone,
  kFile,    ///< ":FILE", which it needs
  kSerial,  ///< ":SERIAL", which may be left out where there is one such device
};

/// A driver. Either `mine` and `open`, for what is plugged in, or `make`, for what is not.
struct DriverEntry {
  std::string_view kind;  ///< as --device has it
  DeviceDriver driver = DeviceDriver::kSimulated;
  std::string_view what;  ///< such a device is, for people
  SourceArgument argument = SourceArgument::kNone;
  std::string_view profile;     ///< of every such device that no other is for, by name
  DriverTraits traits{};        ///< of its devices
  bool takes_poses = false;     ///< its devices have DeviceFacets::poses
  bool plays_gestures = false;  ///< its devices have DeviceFacets::hand
  bool on_time = false;         ///< its devices have OpenDevice::pace

  /// It can drive this one, unless a driver before it in the table can.
  bool (*mine)(const HidrawNode& node) = nullptr;
  /// Throws DeviceError with what is wrong and the remedy.
  OpenDevice (*open)(const FoundDevice& found) = nullptr;
  /// A device of these numbers, whatever driver the sheet names.
  OpenDevice (*make)(const DeviceSheet& sheet, const InsideOptions& options) = nullptr;
};

}  // namespace hapticd
