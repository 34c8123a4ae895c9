// Tells when a hidraw node has come or gone, through udev where it runs and the kernel's own events
// where it does not. Linux. Not RT.
#pragma once

#include <memory>

struct udev;
struct udev_monitor;

namespace hapticd {

class HidrawMonitor {
 public:
  /// Throws std::runtime_error where the system gives no events.
  HidrawMonitor();
  ~HidrawMonitor();
  HidrawMonitor(const HidrawMonitor&) = delete;
  HidrawMonitor& operator=(const HidrawMonitor&) = delete;

  /// Readable while events wait.
  [[nodiscard]] int file() const noexcept;
  /// Takes all that wait.
  void drain() noexcept;

 private:
  struct Close {
    void operator()(udev* context) const noexcept;
    void operator()(udev_monitor* monitor) const noexcept;
  };
  std::unique_ptr<udev, Close> udev_;
  std::unique_ptr<udev_monitor, Close> monitor_;
};

}  // namespace hapticd
