// See device_factory.h.
#include "device/attach/device_factory.h"

namespace hapticd {

std::unique_ptr<HapticDevice> make_device(const DeviceProfile& profile,
                                          const DeviceOptions& options) {
  DeviceProfile own = profile;
  if (const auto* simulated = std::get_if<SimulatedOptions>(&options)) {
    own.driver = DeviceDriver::kSimulated;
    return std::make_unique<SimulatedDevice>(own, *simulated);
  }
  if (const auto* scripted = std::get_if<ScriptedOptions>(&options)) {
    own.driver = DeviceDriver::kScripted;
    return std::make_unique<ScriptedDevice>(own, *scripted);
  }
  own.driver = std::get<ReplayOptions>(options).driver;
  return std::make_unique<ReplayDevice>(own);
}

}  // namespace hapticd
