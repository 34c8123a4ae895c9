// An open hidraw node, this process's alone: a file for the reader and a handle of hidapi for all
// else; a further one for features while those are in use. The reader goes past hidapi: one handle
// in two threads is not safe in hidapi 0.13, its read takes two system calls, allocates when it
// fails, and there is no way to wait with it for less than a millisecond. Opened, used for features
// and closed by one thread. Not RT; the calls of channel() are as they say.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "device/api/report_channel.h"
#include "device/report_io/hidraw_nodes.h"

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
  /// The node for the reader, locked against other processes for as long as it is open.
  struct File {
    int number = -1;
    ~File();
  };

  HidrawNode node_;
  File input_;
  Handle output_;
  Handle features_;  ///< null: not yet needed
};

}  // namespace hapticd
