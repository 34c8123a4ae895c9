// What kind of request an Item is: the table of PROTOCOL.md, section 8. Not RT.
#pragma once

#include <cstdint>

#include "hapticd/v1/stream.pb.h"

namespace hapticd {

/// A kind of Item that a client may send and this version knows. Bye and Chunk are none.
[[nodiscard]] bool is_request(const v1::Item& item);

/// The session must hold the lease.
[[nodiscard]] bool needs_lease(const v1::Item& item);

/// The session must have the right to control.
[[nodiscard]] inline bool needs_control(const v1::Item& item) {
  return needs_lease(item) || item.has_acquire() || item.has_stop();
}

/// What carrying a request out costs the thread that also has to hear a Stop.
enum class Cost : std::uint8_t {
  kLittle,
  kMuch,  ///< it goes through a whole scene: one at a time between two looks at the socket
  kDear,  ///< it looks at files: so too, and of each session one in kDearPeriod_ns
};
[[nodiscard]] Cost cost_of(const v1::Item& item);

/// Run{STEP}: ticks are advanced until it is answered.
[[nodiscard]] inline bool is_run_of_steps(const v1::Item& item) {
  return item.has_run() && item.run().mode() == v1::RUN_MODE_STEP;
}

/// Run{STOP}.
[[nodiscard]] inline bool is_run_stop(const v1::Item& item) {
  return item.has_run() && item.run().mode() == v1::RUN_MODE_STOP;
}

}  // namespace hapticd
