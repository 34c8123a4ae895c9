// What a server counts, by the names under which clients, logs and metrics show it: the one table
// of them. PROTOCOL.md, section 8. Not RT.
#pragma once

#include <cstdint>
#include <span>

#include "hapticd/v1/answer.pb.h"
#include "server/network/server_host.h"

namespace hapticd {

/// Something that is counted.
struct CountedCause {
  const char* name;  ///< small letters and '_', never changed
  bool loss;         ///< something was not used, refused or cut short: the log says so
  std::uint64_t (*count)(const ServerCounters&);
};

/// All of them, in the order in which they are shown.
[[nodiscard]] std::span<const CountedCause> counted_causes();

/// The answer to GetCounts.
[[nodiscard]] v1::Counts counts_of(const ServerCounters& counters);

}  // namespace hapticd
