// A USB device made of the reference firmware, plugged into the kernel's virtual host controller
// (vhci_hcd): we answer its transfers in the USB/IP protocol (Linux, Documentation/usb/
// usbip_protocol.rst) over a pair of sockets. The kernel's own usbcore and usbhid enumerate and
// drive it. One transaction of each interrupt endpoint per frame, as a bus has. Needs root and
// vhci_hcd, so mostly a guest (guest.py). Not RT.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <string>
#include <thread>
#include <vector>

#include "tests/vm/plugged_firmware.h"

namespace hapticd::test {

/// Speeds by their numbers in the kernel; frames of 1 ms and of 125 us.
enum class UsbSpeed : std::uint8_t { kFull = 2, kHigh = 3 };

class UsbipDevice {
 public:
  /// Plugs it in, into the first free port. Throws std::system_error when there is none.
  explicit UsbipDevice(const FirmwareOptions& options, UsbSpeed speed = UsbSpeed::kFull);
  /// Unplugs it: all transfers under way end.
  ~UsbipDevice();
  UsbipDevice(const UsbipDevice&) = delete;
  UsbipDevice& operator=(const UsbipDevice&) = delete;

  /// Whether the OUT endpoint answers NAK to everything.
  void hang_output(bool hangs) { output_hangs_ = hangs; }
  /// The feature report that is answered by STALL; 0 none but those it does not have.
  void stall_feature(std::uint8_t id) { stalled_feature_ = id; }
  [[nodiscard]] PluggedFirmware& firmware() { return firmware_; }
  /// Transfers that the OUT endpoint owes an answer.
  [[nodiscard]] std::size_t waiting_outputs() const { return waiting_outputs_; }

 private:
  using Bytes = std::vector<std::uint8_t>;
  /// A transfer that the host has begun.
  struct Transfer {
    std::uint32_t number = 0;
    std::uint32_t length = 0;             ///< bytes of it, or room
    std::array<std::uint8_t, 8> setup{};  ///< of a control transfer
    Bytes data;                           ///< to the device
  };
  /// How a control transfer ends.
  struct Answer {
    bool stall = false;
    Bytes data;
  };

  void run();
  void frame();
  /// The next message of the host. False at the end of the connection.
  bool take_message();
  void control(const Transfer& transfer, bool to_host);
  void unlink(std::uint32_t number, std::uint32_t victim);
  [[nodiscard]] Answer standard(const Transfer& transfer) const;
  [[nodiscard]] Answer descriptor(std::uint8_t type, std::uint8_t index) const;
  Answer hid_class(const Transfer& transfer);
  /// Ends a transfer; `done` counts bytes to the device.
  void complete(std::uint32_t number, std::int32_t status, std::uint32_t done, const Bytes& data);

  PluggedFirmware firmware_;
  FirmwareOptions options_;
  std::int64_t frame_ns_;
  int socket_ = -1;
  std::deque<Transfer> inputs_, outputs_;
  std::atomic<std::size_t> waiting_outputs_{0};
  std::atomic<bool> output_hangs_{false};
  std::atomic<std::uint8_t> stalled_feature_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace hapticd::test
