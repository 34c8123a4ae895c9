// What the log says of losses on the network: once a second, when one of their counts has moved.
// Pure: no clock, no log. Times are ns, never going back. Not RT.
#pragma once

#include <cstdint>
#include <string>

#include "proto/wire/item_outbox.h"
#include "server/network/counted_causes.h"

namespace hapticd {

/// Shortest time between two reports, ns.
inline constexpr std::int64_t kLossReport_ns = 1000 * wire::kMillisecond_ns;

class LossReport {
 public:
  /// "forged 500 (500 so far), repeated 2 (7 so far)": what has moved since the last report; empty
  /// when nothing has, or it is not yet time.
  std::string next(const ServerCounters& counters, std::int64_t now_ns) {
    if (now_ns < due_ns_) return {};
    due_ns_ = now_ns + kLossReport_ns;
    return rest(counters);
  }

  /// The same at the end, whatever the time.
  std::string rest(const ServerCounters& counters) {
    std::string text;
    for (const CountedCause& cause : counted_causes()) {
      const std::uint64_t now = cause.count(counters);
      const std::uint64_t before = cause.count(told_);
      if (!cause.loss || now == before) continue;
      if (!text.empty()) text += ", ";
      text += std::string(cause.name) + ' ' + std::to_string(now - before) + " (" +
              std::to_string(now) + " so far)";
    }
    told_ = counters;
    return text;
  }

 private:
  ServerCounters told_;
  std::int64_t due_ns_ = 0;
};

}  // namespace hapticd
