// An open hidraw node, this process's alone: two handles of hidapi, one for the reader and one for
// all else, since one handle in two threads is not safe in hidapi 0.13; a third one for features
// while those are in use. Opened, used for features and closed by one thread. Not RT; the calls of
// channel() are as they say.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "device/report_io/hidraw_nodes.h"
#include "device/report_io/report_channel.h"

struct hid_device_;

namespace hapticd {

/// The device cannot be used; the text says which and why, and the remedy.
class DeviceError : public std::runtime_error {
 public:
  DeviceError(const HidrawNode& node, const std::string& what, const std::string& remedy)
      : std::runtime_error(describe(node) + ": " + what + ". " + remedy) {}
};

class HidrawHandles {
 public:
  /// Opens the node and switches USB autosuspend off where that is permitted. Throws DeviceError:
  /// no permission, in use, gone.
  explicit HidrawHandles(const HidrawNode& node);
  ~HidrawHandles();
  HidrawHandles(const HidrawHandles&) = delete;
  HidrawHandles& operator=(const HidrawHandles&) = delete;

  /// Valid as long as this.
  [[nodiscard]] ReportChannel channel() noexcept;
  /// For feature reports while other threads use channel(): a third handle, opened with the first
  /// call and kept. Its `input` is null. Throws DeviceError.
  [[nodiscard]] ReportChannel features();

 private:
  struct Close {
    void operator()(hid_device_* handle) const noexcept;
  };
  using Handle = std::unique_ptr<hid_device_, Close>;
  /// The node, locked against other processes for as long as it is open.
  struct Lock {
    int file = -1;
    ~Lock();
  };

  HidrawNode node_;
  Lock lock_;
  Handle input_;
  Handle output_;
  Handle features_;  ///< null: not yet needed
};

}  // namespace hapticd
