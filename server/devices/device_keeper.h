// Keeps a device attached whose driver runs in the loop: sees it go, waits, finds it again by its
// serial under whatever node, prepares it and lets the loop at it. A thread of its own does what
// may wait. Not RT.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "device/report_io/hidraw_handles.h"
#include "server/devices/hidraw_monitor.h"

namespace hapticd {

/// What a keeper has to know of a driver. All but `failed` are called by one thread at a time.
struct KeptDriver {
  std::function<bool(const HidrawNode&)> mine;  ///< it can drive this one
  /// Makes an open device ready and lets the loop at it. Throws DeviceError.
  std::function<void(const HidrawNode&, const ReportChannel&)> attach;
  std::function<void()> detach;  ///< returns when the loop is not at it
  std::function<bool()> failed;  ///< the device is gone. Any thread
  /// Between two looks, while it is attached; may be empty. The thread of attach.
  std::function<void(HidrawHandles&)> tend;
};

/// The nodes that are plugged in and `mine`, permitted or not.
[[nodiscard]] std::vector<HidrawNode> find_nodes(
    const std::function<bool(const HidrawNode&)>& mine);

/// The one of this serial, or the only one where `serial` is empty. Throws std::runtime_error with
/// what there is instead; `kind` says what is looked for.
[[nodiscard]] HidrawNode find_node(const std::function<bool(const HidrawNode&)>& mine,
                                   const std::string& serial, const std::string& kind);

class DeviceKeeper {
 public:
  /// Attaches the device of `node`, whose handles are open. Throws what KeptDriver::attach does.
  DeviceKeeper(KeptDriver driver, const HidrawNode& node, std::unique_ptr<HidrawHandles> handles);
  /// Detaches it.
  ~DeviceKeeper();
  DeviceKeeper(const DeviceKeeper&) = delete;
  DeviceKeeper& operator=(const DeviceKeeper&) = delete;

  /// Product, serial and node, or that it is unplugged. Any thread.
  [[nodiscard]] std::string port() const;
  [[nodiscard]] const std::string& serial() const noexcept { return serial_; }

 private:
  void run();
  void let_go();
  void try_again();
  void tell_port(const std::string& port);

  KeptDriver driver_;
  std::string serial_;
  HidrawMonitor monitor_;
  std::unique_ptr<HidrawHandles> handles_;  ///< null: unplugged
  mutable std::mutex port_mutex_;
  std::string port_;
  std::string told_;  ///< last reason why it could not be attached
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace hapticd
