// See simulated_driver.h.
#include "device/simulated/simulated_driver.h"

#include "device/simulated/simulated_device.h"

namespace hapticd {

OpenDevice make_simulated(const DeviceSheet& sheet, const InsideOptions& options) {
  DeviceProfile profile = sheet.profile;
  profile.driver = DeviceDriver::kSimulated;
  SimulatedOptions simulated;
  simulated.X_DH = options.X_DH;
  simulated.arm = options.arm;
  simulated.seed = options.seed;
  auto device = std::make_unique<SimulatedDevice>(profile, simulated);
  OpenDevice made;
  made.facets.hand = device.get();
  made.device = std::move(device);
  return made;
}

}  // namespace hapticd
