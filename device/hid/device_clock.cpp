// See device_clock.h. RT: yes.
#include "device/hid/device_clock.h"

#include <algorithm>

namespace hapticd::hid {

std::int64_t host_time(std::int64_t device_ns, std::int64_t arrival_ns,
                       ClockMatch& match) noexcept {
  const std::int64_t difference = arrival_ns - device_ns;
  if (device_ns >= match.window_end_ns) {
    match.least_ns[1] = match.least_ns[0];
    match.least_ns[0] = difference;
    match.window_end_ns = device_ns + kClockWindow_ns;
  } else {
    match.least_ns[0] = std::min(match.least_ns[0], difference);
  }
  return device_ns + std::min(match.least_ns[0], match.least_ns[1]);
}

}  // namespace hapticd::hid
