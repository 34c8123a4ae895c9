// What haptic-osc says: events and States of the daemon as OSC messages of the namespace /haptic,
// which clients/osc/README.md describes. Values alone; liblo sends them. Pure. Not RT.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "hapticd/v1/stream.pb.h"

namespace hapticd::osc {

/// An argument: type tag i, f or s.
using OscArgument = std::variant<std::int32_t, float, std::string>;

/// A message, and the instant that it is about.
struct OscMessage {
  std::string path;
  std::vector<OscArgument> arguments;
  std::uint64_t t_ns = 0;  ///< of the daemon's clock; 0 = now
};

/// The message of an event or a scene; nothing for Items that OSC does not get.
[[nodiscard]] std::optional<OscMessage> message_of(const v1::Item& item);

/// /haptic/pose for every tool of a State.
[[nodiscard]] std::vector<OscMessage> poses_of(const v1::State& state);

}  // namespace hapticd::osc
