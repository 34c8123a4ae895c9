// See scripted_driver.h.
#include "device/scripted/scripted_driver.h"

#include "device/scripted/scripted_device.h"

namespace hapticd {

OpenDevice make_scripted(const DeviceSheet& sheet, const InsideOptions& options) {
  DeviceProfile profile = sheet.profile;
  profile.driver = DeviceDriver::kScripted;
  ScriptedOptions scripted;
  scripted.p_DH = to_array(options.X_DH.p);
  scripted.q_DH = to_array(options.X_DH.q);
  scripted.hold = options.virtual_time;
  auto device = std::make_unique<ScriptedDevice>(profile, scripted);
  OpenDevice made;
  made.facets.poses = device.get();
  made.device = std::move(device);
  return made;
}

}  // namespace hapticd
