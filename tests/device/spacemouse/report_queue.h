// A device that has a queue of reports, as a channel: what hidraw gives its reader. Not RT.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <vector>

#include "device/api/report_channel.h"

namespace hapticd::test {

using Bytes = std::vector<std::uint8_t>;

struct ReportQueue {
  std::deque<Bytes> reports;
  bool gone = false;

  ReportChannel channel() {
    ReportChannel made;
    made.input = this;
    made.read = [](void* input, std::uint8_t* bytes, std::size_t room) noexcept -> int {
      auto& self = *static_cast<ReportQueue*>(input);
      if (self.gone) return -1;
      if (self.reports.empty()) return 0;
      const Bytes report = self.reports.front();
      self.reports.pop_front();
      const std::size_t length = std::min(report.size(), room);
      std::copy_n(report.begin(), length, bytes);
      return static_cast<int>(length);
    };
    return made;
  }
};

}  // namespace hapticd::test
