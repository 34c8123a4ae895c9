// Keeps a device attached whose driver runs in the loop: sees it go, waits, finds it again by its
// serial under whatever node, prepares it and lets the loop at it. A thread of its own does what
// may wait. Not RT.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "device/api/driver.h"
#include "device/attach/hidraw_monitor.h"
#include "device/report_io/hidraw_handles.h"

namespace hapticd {

/// Tells whether a driver can drive a device.
using IsMine = std::function<bool(const HidrawNode&)>;

/// The nodes that are plugged in and `mine`, permitted or not.
[[nodiscard]] std::vector<HidrawNode> find_nodes(const IsMine& mine);

/// The one of this serial, or the only one where `serial` is empty. Throws std::runtime_error with
/// what there is instead; `kind` says what is looked for.
[[nodiscard]] HidrawNode find_node(const IsMine& mine, const std::string& serial,
                                   const std::string& kind);

class Attachment {
 public:
  /// Attaches the device of `node`, whose handles are open; goes on with one of the same serial
  /// that is `mine`. Throws what Plug::attach does.
  Attachment(Plug& plug, IsMine mine, const HidrawNode& node,
             std::unique_ptr<HidrawHandles> handles);
  /// Detaches it.
  ~Attachment();
  Attachment(const Attachment&) = delete;
  Attachment& operator=(const Attachment&) = delete;

  /// Product, serial and node, or that it is unplugged. Any thread.
  [[nodiscard]] std::string port() const;
  [[nodiscard]] const std::string& serial() const noexcept { return serial_; }

 private:
  void attach(const HidrawNode& node);
  void run();
  void let_go();
  void try_again();
  void tell_port(const std::string& port);

  Plug& plug_;
  IsMine mine_;
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
