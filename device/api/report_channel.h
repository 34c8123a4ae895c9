// An open HID device as calls on bytes: reports in, reports out, features. hidraw and hidapi are
// behind it in production (hidraw_handles.h), a device inside the process in tests. Plain data.
#pragma once

#include <cstddef>
#include <cstdint>

namespace hapticd {

/// Longest report of any device here, its ID included, bytes.
inline constexpr std::size_t kMaxReport = 64;

/// Valid as long as what it points to. One thread reads, one other does all else.
struct ReportChannel {
  void* input = nullptr;   ///< for read
  void* output = nullptr;  ///< for the others
  /// The oldest unread input report, ID first; its length, 0 when there is none, -1 when the device
  /// is gone. Never waits. RT as far as the system call is.
  int (*read)(void* input, std::uint8_t* bytes, std::size_t room) noexcept = nullptr;
  /// Sends an output report, ID first; the bytes sent, -1 when the device is gone or does not take
  /// it. May wait for seconds.
  int (*write)(void* output, const std::uint8_t* bytes, std::size_t length) noexcept = nullptr;
  /// Asks for the feature report whose ID is bytes[0]; its length with the ID, -1 when refused. May
  /// wait for seconds.
  int (*get_feature)(void* output, std::uint8_t* bytes, std::size_t room) noexcept = nullptr;
  /// Sends a feature report, ID first; -1 when refused. May wait for seconds.
  int (*set_feature)(void* output, const std::uint8_t* bytes,
                     std::size_t length) noexcept = nullptr;
  /// Waits until an input report is there, or until `until_ns` by the monotonic clock: 1, or 0; -1
  /// when the device is gone. Of the thread that reads. One system call; null: it cannot be waited
  /// for.
  int (*wait)(void* input, std::int64_t until_ns) noexcept = nullptr;
};

}  // namespace hapticd
