// Stops a daemon over its Stop road, which nothing on its network thread delays. Blocks; opens its
// own sockets. Not RT.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "proto/stop/stop_call.h"

namespace hapticd::client {

/// Where the road is.
struct StopPlace {
  std::string host = "127.0.0.1";  ///< name or address
  std::uint16_t port = stop::kDefaultPort;
  stop::StopTarget target;
};

/// What came of a Stop.
struct StopReport {
  bool stopped =
      false;  ///< the daemon has it: its loop latches it with its next tick, if it has not
  bool latched = false;  ///< the loop has latched it
  std::string why;       ///< not stopped: a sentence for people
};

/// Says Stop every 10 ms until the loop has latched it, for `patience`; once the daemon has it, not
/// longer than 100 ms, since virtual time may stand still. Where the host is not this machine and
/// there is no key, nothing is sent.
[[nodiscard]] StopReport stop_by_road(const StopPlace& place, std::chrono::nanoseconds patience);

/// The stop.key in `file`; where that is empty, the one beside `key_file`, if there is one. Throws
/// as noise::read_bare_key() does.
[[nodiscard]] std::optional<stop::SecretKey> named_stop_key(const std::string& file,
                                                            const std::string& key_file);

}  // namespace hapticd::client
