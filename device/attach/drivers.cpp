// See drivers.h.
#include "device/attach/drivers.h"

#include <algorithm>
#include <array>

#include "core/math/assert.h"
#include "device/hid/hid_driver.h"
#include "device/pid/pid_driver.h"
#include "device/replay/replay_driver.h"
#include "device/scripted/scripted_driver.h"
#include "device/simulated/simulated_driver.h"
#include "device/spacemouse/spacemouse_driver.h"

namespace hapticd {
namespace {

// A device of the HID profile may look like one of the PID class too: hid comes before pid.
constexpr std::array kDrivers{kSimulatedDriver, kScriptedDriver, kReplayDriver,
                              hid::kDriver,     pid::kDriver,    spacemouse::kDriver};

}  // namespace

std::span<const DriverEntry> drivers() noexcept { return kDrivers; }

const DriverEntry& driver_entry(DeviceDriver driver) noexcept {
  const auto entry = std::find_if(kDrivers.begin(), kDrivers.end(),
                                  [&](const DriverEntry& each) { return each.driver == driver; });
  HD_ASSERT(entry != kDrivers.end());
  return *entry;
}

std::optional<DeviceSource> parse_source(std::string_view source) {
  const std::size_t colon = std::min(source.find(':'), source.size());
  const auto driver = std::find_if(kDrivers.begin(), kDrivers.end(), [&](const DriverEntry& each) {
    return each.kind == source.substr(0, colon);
  });
  if (driver == kDrivers.end()) return std::nullopt;
  const bool has_colon = colon < source.size();
  const std::string argument(source.substr(std::min(colon + 1, source.size())));
  const bool fits = driver->argument == SourceArgument::kNone   ? !has_colon
                    : driver->argument == SourceArgument::kFile ? has_colon
                                                                : !has_colon || !argument.empty();
  if (!fits) return std::nullopt;
  return DeviceSource{&*driver, argument};
}

const DriverEntry* driver_for(const HidrawNode& node) {
  const auto driver = std::find_if(kDrivers.begin(), kDrivers.end(), [&](const DriverEntry& each) {
    return each.mine != nullptr && each.mine(node);
  });
  return driver == kDrivers.end() ? nullptr : &*driver;
}

DeviceDriver recorded_driver(std::string_view source, const DeviceProfile& profile) {
  const std::optional<DeviceSource> parsed = parse_source(source);
  return parsed && parsed->driver->make != nullptr ? parsed->driver->driver : profile.driver;
}

}  // namespace hapticd
