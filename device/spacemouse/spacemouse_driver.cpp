// See spacemouse_driver.h.
#include "device/spacemouse/spacemouse_driver.h"

#include "device/spacemouse/spacemouse_device.h"

namespace hapticd::spacemouse {
namespace {

class SpacemousePlug final : public Plug {
 public:
  explicit SpacemousePlug(SpacemouseDevice& device) : device_(device) {}
  [[nodiscard]] std::string attach(const HidrawNode& /*node*/,
                                   const ReportChannel& channel) override {
    device_.attach(channel);
    return "";
  }
  void detach() override { device_.detach(); }
  [[nodiscard]] bool failed() const noexcept override { return device_.failed(); }

 private:
  SpacemouseDevice& device_;
};

}  // namespace

bool is_mine(const HidrawNode& node) {
  if (has_six_axes(node.descriptor)) return true;
  return is_spacemouse(node.vendor_id, node.product_id) &&
         !is_receiver(node.vendor_id, node.product_id);
}

OpenDevice open(const FoundDevice& found) {
  SpacemouseSettings settings;
  settings.axes = found.chosen.axes;
  auto device = std::make_unique<SpacemouseDevice>(found.chosen.profile, settings);
  OpenDevice opened;
  opened.plug = std::make_unique<SpacemousePlug>(*device);
  opened.device = std::move(device);
  return opened;
}

}  // namespace hapticd::spacemouse
