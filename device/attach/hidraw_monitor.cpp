// See hidraw_monitor.h.
#include "device/attach/hidraw_monitor.h"

#include <libudev.h>
#include <unistd.h>

#include <stdexcept>

namespace hapticd {

void HidrawMonitor::Close::operator()(udev* context) const noexcept { udev_unref(context); }

void HidrawMonitor::Close::operator()(udev_monitor* monitor) const noexcept {
  udev_monitor_unref(monitor);
}

// udev's own events come once it has set permissions, the kernel's before that.
HidrawMonitor::HidrawMonitor() : udev_(udev_new()) {
  const bool runs = access("/run/udev/control", F_OK) == 0;
  if (udev_ != nullptr) {
    monitor_.reset(udev_monitor_new_from_netlink(udev_.get(), runs ? "udev" : "kernel"));
  }
  if (monitor_ == nullptr ||
      udev_monitor_filter_add_match_subsystem_devtype(monitor_.get(), "hidraw", nullptr) < 0 ||
      udev_monitor_enable_receiving(monitor_.get()) < 0) {
    throw std::runtime_error("the system does not report devices that are plugged in");
  }
}

HidrawMonitor::~HidrawMonitor() = default;

int HidrawMonitor::file() const noexcept { return udev_monitor_get_fd(monitor_.get()); }

void HidrawMonitor::drain() noexcept {
  while (udev_device* device = udev_monitor_receive_device(monitor_.get())) {
    udev_device_unref(device);
  }
}

}  // namespace hapticd
