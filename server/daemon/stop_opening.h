// Where the Stop road of this run is to be, and its opening. Not RT.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "hapticd/v1/config.pb.h"
#include "server/haptic_loop/stop_line.h"
#include "server/stop_road/stop_road.h"

namespace hapticd {

/// What the configuration says of the road.
struct StopPlan {
  bool off = false;
  std::string host;  ///< empty: that of the sessions
  std::uint16_t port = stop::kDefaultPort;
  std::optional<stop::SecretKey> key;
};

/// Throws StartError, naming the option, for an address that is none and a key that is no good.
[[nodiscard]] StopPlan stop_plan(const v1::Config& config);

/// Throws the StartErrors of open_stop_road() that need no socket.
void check_stop_plan(const StopPlan& plan);

/// Opens the road of the daemon whose sessions are at `listened`, ADDR:PORT, and says in the log
/// where; null where it is off. Throws StartError for an address that cannot be had, and for one
/// that others reach while there is no key.
[[nodiscard]] std::unique_ptr<StopRoad> open_stop_road(const StopPlan& plan,
                                                       const std::string& listened, StopLine& line);

}  // namespace hapticd
