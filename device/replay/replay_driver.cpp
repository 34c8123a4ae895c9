// See replay_driver.h.
#include "device/replay/replay_driver.h"

#include "device/replay/replay_device.h"

namespace hapticd {

OpenDevice make_replay(const DeviceSheet& sheet, const InsideOptions& options) {
  DeviceProfile profile = sheet.profile;
  profile.driver = options.recorded;
  auto device = std::make_unique<ReplayDevice>(profile);
  OpenDevice made;
  made.facets.samples = device.get();
  made.device = std::move(device);
  return made;
}

}  // namespace hapticd
